// The control groups of a process, in which containers, services and batch jobs are limited. Reads
// only; thread-safe.   Source: cgroups(7), "Documentation/admin-guide/cgroup-v2.rst" and
// "cgroup-v1".
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace parallax {

// Returns the folders of the control groups that `groups` names (the text of /proc/self/cgroup) and
// of the groups above them, innermost first: those of the unified hierarchy at `root`, and those of
// the older one at `root`/`controller`. They need not exist: a container may not see its own group.
// `root` is the mount point of the cgroup file systems.
std::vector<std::string> CgroupFolders(std::string_view groups, const std::string& root,
                                       const std::string& controller);

// Returns the smallest quota of CPU time, in cores, of the control groups that `groups` names and
// of those above them; 0 if none has one. Arguments as above.
double CgroupCpuLimit(std::string_view groups, const std::string& root);

// Returns the text of /proc/self/cgroup; "" where none exists.
std::string OwnCgroups();

}  // namespace parallax

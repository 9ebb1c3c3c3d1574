// Figures of the operating system: CPU seconds, memory, the disk's rate, the machine.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

double ProcessCpuSeconds();  // User and system, of this process.
// CPU seconds of another process of this machine, from /proc. 0 when it is gone.
double CpuSecondsOf(int pid);
double PeakRssMb(int pid);
double FileMb(const std::string& path);  // 0 when none exists.
// Appends of one page, each made durable, for `seconds`.
absl::StatusOr<double> FdatasyncPerSecond(const std::string& folder, double seconds);
// "Intel(R) Xeon(R) ..., 2 cores"
std::string MachineText();
// First line that `command` prints; empty when it fails.
std::string FirstLineOf(const std::string& command);

}  // namespace parallax

#include "coordinator/init.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "common/base/shell_word.h"
#include "common/base/system/file.h"
#include "common/base/system/secret.h"
#include "common/rpc/certificate.h"
#include "common/rpc/revocation.h"
#include "common/store/store.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr double kAuthorityDays = 3650;
constexpr char kServerFolder[] = "server";  // In the folder of the farm.

absl::Status WritePrivate(const std::string& path, const std::string& bytes) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd < 0) return ErrnoError(errno, "make " + path);
  close(fd);
  return WriteFile(path, bytes, /*sync=*/true);
}

struct FileToMake {
  std::string name;
  std::string bytes;
};

// Renames `temporary` to `folder`, which must not exist; `replace`: exchanges the two.
absl::Status MoveIntoPlace(const std::string& temporary, const std::string& folder, bool replace) {
  const unsigned flags = replace ? RENAME_EXCHANGE : RENAME_NOREPLACE;
  if (renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, folder.c_str(), flags) == 0) {
    return absl::OkStatus();
  }
  // NFS and kernels before 3.15 can't do it in one step.
  if (errno != EINVAL && errno != ENOSYS) return ErrnoError(errno, "make " + folder);
  const std::string old = temporary + ".old";
  if (!replace && access(folder.c_str(), F_OK) == 0) return ErrnoError(EEXIST, "make " + folder);
  if (replace && rename(folder.c_str(), old.c_str()) != 0) {
    return ErrnoError(errno, "replace " + folder);
  }
  if (rename(temporary.c_str(), folder.c_str()) != 0) return ErrnoError(errno, "make " + folder);
  if (replace && rename(old.c_str(), temporary.c_str()) != 0) {
    return ErrnoError(errno, "remove " + old);
  }
  return absl::OkStatus();
}

// The folder with its files appears whole or not at all, private from its first moment. `replace`:
// in place of the one that is there.
absl::Status MakeFolder(const std::string& dir, const std::string& name,
                        const std::vector<FileToMake>& files, bool replace = false) {
  const std::string folder = dir + "/" + name;
  const std::string temporary = dir + "/.new-" + name;
  std::error_code error;
  fs::remove_all(temporary, error);  // Left by an interrupted init.
  if (mkdir(temporary.c_str(), 0700) != 0) return ErrnoError(errno, "make " + temporary);
  for (const FileToMake& file : files) {
    RETURN_IF_ERROR(WritePrivate(temporary + "/" + file.name, file.bytes));
  }
  RETURN_IF_ERROR(SyncPath(temporary));
  RETURN_IF_ERROR(MoveIntoPlace(temporary, folder, replace));
  RETURN_IF_ERROR(SyncPath(dir));
  if (replace) fs::remove_all(temporary, error);
  return absl::OkStatus();
}

std::vector<FileToMake> IdentityFiles(const KeyPair& authority, const KeyPair& own) {
  return {{"ca.crt", authority.certificate_pem},
          {"tls.crt", own.certificate_pem},
          {"tls.key", own.key_pem}};
}

void AddHosts(const std::vector<std::string>& more, std::vector<std::string>& hosts) {
  for (const std::string& host : more) {
    if (std::count(hosts.begin(), hosts.end(), host) == 0) hosts.push_back(host);
  }
}

std::vector<std::string> HostsOf(const InitOptions& options) {
  std::vector<std::string> hosts;
  AddHosts(options.hosts, hosts);
  char name[256] = "";
  if (gethostname(name, sizeof name - 1) == 0 && name[0] != '\0') AddHosts({name}, hosts);
  AddHosts({"localhost", "127.0.0.1", "::1"}, hosts);
  return hosts;
}

std::string Join(const std::vector<std::string>& texts) {
  std::string joined;
  for (const std::string& text : texts) joined += (joined.empty() ? "" : ", ") + text;
  return joined;
}

bool Exists(const std::string& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() != fs::file_type::not_found;
}

std::string FolderOf(const std::pair<std::string, std::string>& issue) {
  return issue.first + "-" + issue.second;
}

absl::Status Check(const InitOptions& options) {
  const std::string& dir = options.dir;
  const bool has_authority = Exists(dir + "/ca");
  const bool has_server = Exists(dir + "/server");
  if (!has_authority && has_server) {
    return FailedPrecondition("{} has a server's certificate but no authority (ca/)", dir);
  }
  const bool renews_server =
      std::count(options.renew.begin(), options.renew.end(), kServerFolder) > 0;
  if (has_server && !options.hosts.empty() && !renews_server) {
    return AlreadyExists(
        "{}/server is there already; --renew server --host NAME makes its certificate anew with "
        "this host too",
        dir);
  }
  const bool has_more_to_do =
      !options.issue.empty() || !options.renew.empty() || !options.revoke.empty();
  if (has_server && !has_more_to_do) {
    return AlreadyExists(
        "{} has an authority and a server's certificate already; issue others with --issue ROLE "
        "NAME",
        dir);
  }
  for (const auto* folders : {&options.revoke, &options.renew}) {
    for (const std::string& folder : *folders) {
      if (folder.find('/') == std::string::npos && Exists(dir + "/" + folder + "/tls.crt"))
        continue;
      return NotFound(
          "{} has no folder '{}' with a certificate; folders are server, worker-NAME, "
          "submitter-NAME, operator-NAME, read-only-NAME",
          dir, folder);
    }
  }
  for (const auto& issue : options.issue) {
    if (!ParseRole(issue.first)) {
      return InvalidArgument("role '{}': allowed are worker, submitter, operator, read-only",
                             issue.first);
    }
    if (const std::string folder = dir + "/" + FolderOf(issue); Exists(folder)) {
      return AlreadyExists("{} is there already; nothing was overwritten", folder);
    }
  }
  return absl::OkStatus();
}

absl::Status Revoke(const std::string& dir, const std::string& folder, std::ostream& out) {
  ASSIGN_OR_RETURN(const std::string pem, ReadFile(dir + "/" + folder + "/tls.crt", 1 << 20));
  ASSIGN_OR_RETURN(const CertificateFacts facts, ReadCertificate(pem));
  const std::string list = dir + "/server/" + kRevokedFile;
  // Farms had no list before their first revocation.
  if (!Exists(list)) RETURN_IF_ERROR(WriteFileAtomically(list, kEmptyRevokedList));
  ASSIGN_OR_RETURN(const auto revoked, RevokedCertificates::Open(list, Clock::System()));
  if (!revoked->Contains(facts.sha256)) {
    ASSIGN_OR_RETURN(std::string text, ReadFile(list, 16 << 20));
    if (!text.empty() && text.back() != '\n') text += '\n';
    RETURN_IF_ERROR(WriteFileAtomically(list, text + facts.sha256 + "  # " + folder + "\n"));
  }
  out << list << "  names the certificate of " << folder
      << "; a coordinator that has this file refuses it from now on\n";
  return absl::OkStatus();
}

// The same party with a new key and a new term. What else the folder holds stays.
absl::Status Renew(const InitOptions& options, const std::string& folder, const KeyPair& authority,
                   double now_s, std::ostream& out) {
  const std::string place = options.dir + "/" + folder;
  ASSIGN_OR_RETURN(const std::string pem, ReadFile(place + "/tls.crt", 1 << 20));
  ASSIGN_OR_RETURN(const CertificateFacts facts, ReadCertificate(pem));
  const CertificateOrder order{.name = facts.name, .now_unix_s = now_s, .days = options.days};
  std::vector<std::string> hosts = facts.hosts;
  AddHosts(options.hosts, hosts);
  absl::StatusOr<KeyPair> own = facts.role ? IssueClient(authority, order, *facts.role)
                                           : IssueServer(authority, order, hosts);
  RETURN_IF_ERROR(own.status());
  std::vector<FileToMake> files = IdentityFiles(authority, *own);
  for (const char* kept : {"http.token", kRevokedFile}) {
    if (!Exists(place + "/" + kept)) continue;
    ASSIGN_OR_RETURN(std::string bytes, ReadFile(place + "/" + kept, 16 << 20));
    files.push_back({kept, std::move(bytes)});
  }
  RETURN_IF_ERROR(MakeFolder(options.dir, folder, files, /*replace=*/true));
  out << place << "  renewed for " << options.days
      << " days; whoever uses it reads it at its next start\n";
  return absl::OkStatus();
}

absl::StatusOr<KeyPair> TakeAuthority(const InitOptions& options, double now_s, std::ostream& out) {
  const std::string folder = options.dir + "/ca";
  KeyPair authority;
  if (Exists(folder)) {
    ASSIGN_OR_RETURN(authority.certificate_pem, ReadFile(folder + "/ca.crt", 1 << 20));
    ASSIGN_OR_RETURN(authority.key_pem, ReadFile(folder + "/ca.key", 1 << 20));
    return authority;
  }
  ASSIGN_OR_RETURN(
      authority,
      MakeAuthority({.name = "parallax-authority", .now_unix_s = now_s, .days = kAuthorityDays}));
  RETURN_IF_ERROR(MakeFolder(
      options.dir, "ca", {{"ca.crt", authority.certificate_pem}, {"ca.key", authority.key_pem}}));
  out << folder << "  the farm's authority; ca.key signs for it, keep it to yourself\n";
  return authority;
}

absl::Status MakeServer(const InitOptions& options, const KeyPair& authority, double now_s,
                        std::ostream& out) {
  const std::vector<std::string> hosts = HostsOf(options);
  ASSIGN_OR_RETURN(
      const KeyPair own,
      IssueServer(authority, {.name = "coordinator", .now_unix_s = now_s, .days = options.days},
                  hosts));
  std::vector<FileToMake> files = IdentityFiles(authority, own);
  ASSIGN_OR_RETURN(const std::string token, NewSecret());
  files.push_back({"http.token", token + "\n"});
  files.push_back({kRevokedFile, kEmptyRevokedList});
  RETURN_IF_ERROR(MakeFolder(options.dir, "server", files));
  out << options.dir << "/server  coordinator serve --tls " << ShellWord(options.dir + "/server")
      << "   (for " << Join(hosts) << ")\n";
  return absl::OkStatus();
}

}  // namespace

absl::Status InitFarm(const InitOptions& options, Clock& clock, std::ostream& out) {
  RETURN_IF_ERROR(Check(options));
  std::error_code error;
  fs::create_directories(options.dir, error);
  if (error) return ErrnoError(error.value(), "make " + options.dir);
  const double now_s = clock.UnixSeconds();
  // Bad names and hosts show before anything is written.
  {
    ASSIGN_OR_RETURN(const KeyPair trial,
                     MakeAuthority({.name = "trial", .now_unix_s = now_s, .days = options.days}));
    RETURN_IF_ERROR(IssueServer(trial, {.name = "trial", .now_unix_s = now_s, .days = options.days},
                                HostsOf(options))
                        .status());
    for (const auto& [role, name] : options.issue) {
      RETURN_IF_ERROR(IssueClient(trial, {.name = name, .now_unix_s = now_s, .days = options.days},
                                  *ParseRole(role))
                          .status());
    }
  }
  ASSIGN_OR_RETURN(const KeyPair authority, TakeAuthority(options, now_s, out));
  if (!Exists(options.dir + "/server")) {
    RETURN_IF_ERROR(MakeServer(options, authority, now_s, out));
  }
  for (const std::string& folder : options.revoke) {
    RETURN_IF_ERROR(Revoke(options.dir, folder, out));
  }
  for (const std::string& folder : options.renew) {
    RETURN_IF_ERROR(Renew(options, folder, authority, now_s, out));
  }
  for (const auto& issue : options.issue) {
    const Role role = *ParseRole(issue.first);
    ASSIGN_OR_RETURN(
        const KeyPair own,
        IssueClient(authority, {.name = issue.second, .now_unix_s = now_s, .days = options.days},
                    role));
    RETURN_IF_ERROR(MakeFolder(options.dir, FolderOf(issue), IdentityFiles(authority, own)));
    out << options.dir << "/" << FolderOf(issue) << "  "
        << (role == Role::kWorker ? "worker --role all" : "parallax watch")
        << " --coordinator HOST:7070 --tls " << FolderOf(issue) << "\n";
  }
  return absl::OkStatus();
}

}  // namespace parallax

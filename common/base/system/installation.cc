#include "common/base/system/installation.h"

#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <filesystem>

#include "common/base/shell_word.h"
#include "common/base/system/file.h"
#include "common/base/version.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

InstalledAs KindOf(const std::string& data) {
  const std::string written = ReadFile(data + "/installed_as").value_or("");
  if (written == "wheel\n") return InstalledAs::kWheel;
  if (written == "deb\n") return InstalledAs::kDebianPackage;
  return InstalledAs::kTarball;
}

// Returns the absolute path of the file that an environment variable names; empty if it names none.
absl::StatusOr<std::string> NamedBy(const std::string& variable, int access_mode) {
  const char* const named = std::getenv(variable.c_str());
  if (named == nullptr || *named == '\0') return std::string();
  if (access(named, access_mode) == 0) return fs::absolute(named).string();
  return ErrnoError(errno, "$" + variable + ": " + named);
}

}  // namespace

Installation InstallationOf(const std::string& program) {
  const fs::path folder = fs::path(program).parent_path();
  if (folder.filename() != "libexec")
    return {.as = InstalledAs::kBuild, .programs = folder, .data = ""};
  const fs::path root = folder.parent_path();
  const std::string data = root / "share/parallax";
  return {.as = KindOf(data), .programs = root / "bin", .data = data};
}

const Installation& ThisInstallation() {
  static const Installation installation = [] {
    std::error_code error;
    return InstallationOf(fs::read_symlink("/proc/self/exe", error));
  }();
  return installation;
}

absl::StatusOr<std::string> FindProgram(const std::string& name) {
  std::string variable = "PARALLAX_";
  for (const char c : name) variable += static_cast<char>(std::toupper(c));
  ASSIGN_OR_RETURN(const std::string named, NamedBy(variable, X_OK));
  if (!named.empty()) return named;
  const Installation& installation = ThisInstallation();
  const std::string path = installation.programs + "/" + name;
  if (access(path.c_str(), X_OK) == 0) return path;
  return NotFound("the program `{}` is missing: no {}; {}, or name the program in ${}", name, path,
                  HowToAddProgram(installation, name), variable);
}

absl::StatusOr<std::string> FindNetwork() {
  constexpr char kVariable[] = "PARALLAX_NETWORK";
  ASSIGN_OR_RETURN(const std::string named, NamedBy(kVariable, R_OK));
  if (!named.empty()) return named;
  const Installation& installation = ThisInstallation();
  const bool built = installation.as == InstalledAs::kBuild;
  // CMake links it beside the programs of a build.
  const std::string path = built ? installation.programs + "/network.pt"
                                 : installation.data + "/configs/networks/network.pt";
  if (access(path.c_str(), R_OK) == 0) return path;
  return NotFound(
      "no trained network is at hand (no {}): name a checkpoint of the built-in trainer in ${}; "
      "`parallax run network --out DIR` trains one, DIR/training/all-three/builtin/seed-0/final.pt",
      path, kVariable);
}

std::string HowToAddProgram(const Installation& installation, const std::string& name) {
  const fs::path root = fs::path(installation.programs).parent_path();
  if (installation.as == InstalledAs::kBuild) {
    return fmt::format("build it: cmake --build {} --target {}", ShellWord(root.string()), name);
  }
  if (name != "trainer") return "install Parallax again";
  switch (installation.as) {
    case InstalledAs::kWheel:
      return fmt::format("install its wheel: pip install parallax_stereo_trainer-{}-*.whl",
                         kProgramVersion);
    case InstalledAs::kDebianPackage:
      return fmt::format(
          "install its package: sudo apt-get install ./parallax-stereo-trainer_{}_amd64.deb",
          kProgramVersion);
    default:
      return fmt::format(
          "unpack its tarball: tar -xf parallax-trainer-{}-linux-x86_64.tar.xz -C {} "
          "--strip-components=1",
          kProgramVersion, ShellWord(root.string()));
  }
}

std::string HowToAddRealPair(const Installation& installation) {
  if (installation.as == InstalledAs::kBuild) return "run deploy/setup.sh, which installs it";
  return "install Parallax again";
}

}  // namespace parallax

// How this program was installed, and where the other programs and files of Parallax lie.
//
// A package has ROOT/bin/NAME, which starts ROOT/libexec/NAME with the package's own loader and C
// library, and its data in ROOT/share/parallax (deploy/package.sh makes it). Programs of a build
// lie in one folder.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

enum class InstalledAs { kBuild, kTarball, kWheel, kDebianPackage };

struct Installation {
  InstalledAs as = InstalledAs::kBuild;
  std::string programs;  // The folder of the programs that may be started by their path.
  std::string data;      // A package's ROOT/share/parallax; empty in a build.
};

// Returns the installation that has `program`, the absolute path of its executable file without
// links. Reads ROOT/share/parallax/installed_as; a package without that file counts as a tarball.
Installation InstallationOf(const std::string& program);

// Returns the installation of the program that runs.
const Installation& ThisInstallation();

// Returns the absolute path of a program of Parallax ("worker", "trainer"): $PARALLAX_WORKER,
// $PARALLAX_TRAINER, or the one that was installed with this one.
// Errors: kNotFound with the path and HowToAddProgram; those of access(2) for a variable's program.
absl::StatusOr<std::string> FindProgram(const std::string& name);

// Returns the absolute path of the trained network that comes with Parallax, a checkpoint of the
// built-in trainer: $PARALLAX_NETWORK, or the one that was installed with this program.
// Errors: kNotFound with the path and what the user does to add it; those of access(2) for the
// variable's file.
absl::StatusOr<std::string> FindNetwork();

// Say what the user does to add what is missing, as an order without a full stop: "install its
// wheel: pip install ...".
std::string HowToAddProgram(const Installation& installation, const std::string& name);
std::string HowToAddRealPair(const Installation& installation);  // The benchmark `shipped`.

}  // namespace parallax

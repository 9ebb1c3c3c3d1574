// The command `farm slurm`: keeps workers for a coordinator on a Slurm cluster.
#pragma once

#include "coordinator/client/command.h"

namespace parallax::client {

void RegisterFarm(Registry& registry);

}  // namespace parallax::client

// farm slurm.
#pragma once

#include "coordinator/client/commands/command.h"

namespace parallax::client {

void RegisterFarm(Registry& registry);

}  // namespace parallax::client

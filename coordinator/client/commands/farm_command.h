// The command `farm`: keeps workers for a coordinator in a batch system.
#pragma once

#include "coordinator/client/command.h"

namespace parallax::client {

void RegisterFarm(Registry& registry);

}  // namespace parallax::client

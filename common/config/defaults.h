#pragma once

#include <google/protobuf/message.h>

namespace parallax::config_internal {

// Sets every absent field to the default of its rule, in nested messages too.
void ApplyDefaults(google::protobuf::Message* message);

}  // namespace parallax::config_internal

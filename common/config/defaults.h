#pragma once

#include <google/protobuf/message.h>

namespace parallax::config_internal {

// Sets every field that is absent to its rule's default, through all messages.
void ApplyDefaults(google::protobuf::Message* message);

}  // namespace parallax::config_internal

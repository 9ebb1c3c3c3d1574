// Changes all texts of a message in one place: to cut them before they are sent, and to make them
// printable before a person sees them. Thread-safe.
#pragma once

#include <functional>
#include <string>

namespace google::protobuf {
class Message;
}

namespace parallax {

// Calls `change` for each text of `message` and of its nested messages, with the name of its field,
// and stores the changed text. Keys of maps, bytes, and `source_yaml`, which is a file, stay as
// they are.
void ChangeTexts(google::protobuf::Message* message,
                 const std::function<void(const std::string& field, std::string* text)>& change);

}  // namespace parallax

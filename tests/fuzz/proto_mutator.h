// Changes a message somewhere, by reflection: what byte-wise mutation of its wire form would need
// ages to hit. Numbers become neighbours, extremes, NaN and infinities; strings and repeated fields
// grow, shrink and swap; messages come and go.
#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <limits>

#include "common/base/rng.h"

namespace parallax::fuzz {

class ProtoMutator {
 public:
  explicit ProtoMutator(unsigned int seed) : random_(SceneSeed{seed}, "fuzz") {}

  void Mutate(google::protobuf::Message& message) {
    const google::protobuf::Descriptor& type = *message.GetDescriptor();
    if (type.field_count() == 0) return;
    const auto* field = type.field(static_cast<int>(Draw(type.field_count())));
    const google::protobuf::Reflection& reflection = *message.GetReflection();
    if (field->is_map()) return;
    if (field->is_repeated()) return MutateRepeated(message, *field, reflection);
    if (field->cpp_type() == field->CPPTYPE_MESSAGE) {
      // Mostly deeper.
      if (Draw(8) == 0) return reflection.ClearField(&message, field);
      return Mutate(*reflection.MutableMessage(&message, field));
    }
    if (Draw(10) == 0) return reflection.ClearField(&message, field);
    SetScalar(message, *field, reflection);
  }

 private:
  using Field = google::protobuf::FieldDescriptor;
  uint64_t Draw(uint64_t below) { return random_.Bits64() % below; }

  double Number(double old) {
    switch (Draw(9)) {
      case 0:
        return 0;
      case 1:
        return -old;
      case 2:
        return std::numeric_limits<double>::quiet_NaN();
      case 3:
        return std::numeric_limits<double>::infinity();
      case 4:
        return 1e308;
      case 5:
        return 1e-308;
      case 6:
        return old * 1000;
      case 7:
        return old + 1;
      default:
        return static_cast<double>(random_.Bits64()) / 1e19;
    }
  }
  uint64_t Integer(uint64_t old) {
    switch (Draw(7)) {
      case 0:
        return 0;
      case 1:
        return old + 1;
      case 2:
        return old - 1;
      case 3:
        return ~uint64_t{0};
      case 4:
        return uint64_t{1} << Draw(64);
      case 5:
        return Draw(300);
      default:
        return random_.Bits64();
    }
  }
  std::string Text(std::string old) {
    switch (Draw(6)) {
      case 0:
        return "";
      case 1:
        return old + old;
      case 2:
        return "../" + old;
      case 3:
        return old.substr(0, old.size() / 2);
      case 4:
        return std::string(1, static_cast<char>(Draw(256))) + old;
      default:
        if (!old.empty()) old[Draw(old.size())] = static_cast<char>(Draw(256));
        return old;
    }
  }

  void SetScalar(google::protobuf::Message& m, const Field& f,
                 const google::protobuf::Reflection& r) {
    switch (f.cpp_type()) {
      case Field::CPPTYPE_INT32:
        return r.SetInt32(&m, &f,
                          static_cast<int32_t>(Integer(static_cast<uint64_t>(r.GetInt32(m, &f)))));
      case Field::CPPTYPE_INT64:
        return r.SetInt64(&m, &f,
                          static_cast<int64_t>(Integer(static_cast<uint64_t>(r.GetInt64(m, &f)))));
      case Field::CPPTYPE_UINT32:
        return r.SetUInt32(&m, &f, static_cast<uint32_t>(Integer(r.GetUInt32(m, &f))));
      case Field::CPPTYPE_UINT64:
        return r.SetUInt64(&m, &f, Integer(r.GetUInt64(m, &f)));
      case Field::CPPTYPE_DOUBLE:
        return r.SetDouble(&m, &f, Number(r.GetDouble(m, &f)));
      case Field::CPPTYPE_FLOAT:
        return r.SetFloat(&m, &f, static_cast<float>(Number(r.GetFloat(m, &f))));
      case Field::CPPTYPE_BOOL:
        return r.SetBool(&m, &f, !r.GetBool(m, &f));
      case Field::CPPTYPE_ENUM:
        return r.SetEnumValue(&m, &f, static_cast<int>(Draw(6)));
      case Field::CPPTYPE_STRING: {
        std::string text = Text(r.GetString(m, &f));
        // The parser refuses what is not UTF-8 before we see it.
        for (char& c : text) c = static_cast<char>(c & 0x7f);
        return r.SetString(&m, &f, text);
      }
      case Field::CPPTYPE_MESSAGE:
        return;
    }
  }

  void MutateRepeated(google::protobuf::Message& m, const Field& f,
                      const google::protobuf::Reflection& r) {
    const int size = r.FieldSize(m, &f);
    switch (Draw(4)) {
      case 0:
        if (size > 0) r.RemoveLast(&m, &f);
        return;
      case 1:
        if (size > 1) {
          r.SwapElements(&m, &f, static_cast<int>(Draw(static_cast<uint64_t>(size))),
                         static_cast<int>(Draw(static_cast<uint64_t>(size))));
        }
        return;
      case 2:
        return Append(m, f, r, size);
      default:
        if (size > 0 && f.cpp_type() == Field::CPPTYPE_MESSAGE) {
          Mutate(*r.MutableRepeatedMessage(&m, &f,
                                           static_cast<int>(Draw(static_cast<uint64_t>(size)))));
        }
        return;
    }
  }

  void Append(google::protobuf::Message& m, const Field& f, const google::protobuf::Reflection& r,
              int size) {
    switch (f.cpp_type()) {
      case Field::CPPTYPE_MESSAGE: {
        google::protobuf::Message* added = r.AddMessage(&m, &f);
        if (size > 0) {
          added->CopyFrom(
              r.GetRepeatedMessage(m, &f, static_cast<int>(Draw(static_cast<uint64_t>(size)))));
        }
        return Mutate(*added);
      }
      case Field::CPPTYPE_STRING:
        return r.AddString(&m, &f, "x" + std::to_string(Draw(10)));
      case Field::CPPTYPE_DOUBLE:
        return r.AddDouble(&m, &f, Number(1));
      case Field::CPPTYPE_UINT32:
        return r.AddUInt32(&m, &f, static_cast<uint32_t>(Integer(1)));
      default:
        return;
    }
  }

  Rng random_;
};

}  // namespace parallax::fuzz

#include "common/base/rng.h"

#include <fmt/core.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "common/base/hash.h"

namespace parallax {
namespace {

std::array<uint32_t, 4> AddressOf(std::string_view parent, std::string_view name) {
  const Sha256Digest digest = Sha256().Update(parent).Update("/").Update(name).Finish();
  std::array<uint32_t, 4> address;
  std::memcpy(address.data(), digest.data(), sizeof(address));
  return address;
}

std::string_view BytesOf(const std::array<uint32_t, 4>& address) {
  return {reinterpret_cast<const char*>(address.data()), sizeof(address)};
}

}  // namespace

PhiloxCounter Philox4x32(PhiloxCounter counter, PhiloxKey key) {
  for (int round = 0; round < 10; ++round) {
    const uint64_t product0 = uint64_t{0xD2511F53} * counter[0];
    const uint64_t product1 = uint64_t{0xCD9E8D57} * counter[2];
    counter = {static_cast<uint32_t>(product1 >> 32) ^ counter[1] ^ key[0],
               static_cast<uint32_t>(product1),
               static_cast<uint32_t>(product0 >> 32) ^ counter[3] ^ key[1],
               static_cast<uint32_t>(product0)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

Rng::Rng(SceneSeed seed, std::string_view path)
    : address_(AddressOf({reinterpret_cast<const char*>(&seed.value), sizeof(seed.value)}, path)) {}

Rng Rng::Child(std::string_view name) const { return Rng(AddressOf(BytesOf(address_), name)); }

Rng Rng::Child(std::string_view name, uint64_t index) const {
  return Child(fmt::format("{}/{}", name, index));
}

uint32_t Rng::Bits32() {
  if (next_word_ == 4) {
    words_ = Philox4x32({static_cast<uint32_t>(block_), static_cast<uint32_t>(block_ >> 32),
                         address_[2], address_[3]},
                        {address_[0], address_[1]});
    ++block_;
    next_word_ = 0;
  }
  return words_[static_cast<size_t>(next_word_++)];
}

uint64_t Rng::Bits64() {
  const uint64_t high = Bits32();
  return high << 32 | Bits32();
}

double Rng::Uniform() { return static_cast<double>(Bits64() >> 11) * 0x1p-53; }

double Rng::Uniform(double low, double high) { return low + (high - low) * Uniform(); }

int Rng::UniformInt(int low, int high) {
  const uint64_t count = static_cast<uint64_t>(static_cast<int64_t>(high) - low + 1);
  return low + static_cast<int>((static_cast<unsigned __int128>(Bits64()) * count) >> 64);
}

double Rng::Normal() {
  // Box-Muller; one of the pair is dropped, so that the number of words a draw uses is constant.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * Uniform());
}

}  // namespace parallax

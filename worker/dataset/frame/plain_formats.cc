#include "worker/dataset/frame/plain_formats.h"

#include <fmt/core.h>
#include <zlib.h>

#include <Eigen/Core>
#include <cstdio>
#include <cstring>
#include <vector>

namespace parallax {

namespace {

// `shape`: as Python writes a tuple, without its parentheses.
std::string NpyBytes(const std::string& shape, const std::vector<float>& values) {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + shape + "), }";
  // Magic, version and length are 10 bytes; the whole header ends at a multiple of 64.
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() & 0xff);
  bytes += static_cast<char>(header.size() >> 8);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return bytes;
}

template <typename ImageType>
std::string SizeText(const ImageType& image) {
  return fmt::format("{}, {}", image.height(), image.width());
}

}  // namespace

std::string EncodeNpy(const ImageF& image) { return NpyBytes(SizeText(image), image.values()); }

std::string EncodeNpy(const ImageF3& image) {
  return NpyBytes(SizeText(image) + ", 3", image.values());
}

std::string EncodeFlo(const ImageF3& flow) {
  std::string bytes("PIEH", 4);
  for (const int32_t side : {flow.width(), flow.height()}) {
    bytes.append(reinterpret_cast<const char*>(&side), sizeof(side));
  }
  for (size_t i = 0; i < flow.pixels(); ++i) {
    bytes.append(reinterpret_cast<const char*>(&flow.values()[3 * i]), 2 * sizeof(float));
  }
  return bytes;
}

uint16_t HalfBits(float value) {
  const Eigen::half half(value);
  return Eigen::numext::bit_cast<uint16_t>(half);
}

absl::StatusOr<std::string> Gzip(std::string_view bytes) {
  constexpr int kGzip = 15 + 16;  // Largest window, gzip's header.
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    return Internal("gzip: zlib can't begin");
  }
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) return Internal("gzip: zlib did not finish");
  return packed;
}

absl::StatusOr<std::string> TarMember(std::string_view name, std::string_view content) {
  constexpr size_t kBlock = 512;
  if (name.empty() || name.size() > 100) {
    return InvalidArgument("tar: the name \"{}\" has more than 100 characters", name);
  }
  char header[kBlock] = {};
  std::memcpy(header, name.data(), name.size());
  std::snprintf(header + 100, 8, "%07o", 0644u);
  std::snprintf(header + 108, 8, "%07o", 0u);
  std::snprintf(header + 116, 8, "%07o", 0u);
  std::snprintf(header + 124, 12, "%011llo", static_cast<unsigned long long>(content.size()));
  std::snprintf(header + 136, 12, "%011o", 0u);
  std::memset(header + 148, ' ', 8);
  header[156] = '0';
  std::memcpy(header + 257, "ustar\00000", 8);
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  std::snprintf(header + 148, 8, "%06o", sum);
  std::string bytes(header, kBlock);
  bytes += content;
  bytes.append((kBlock - content.size() % kBlock) % kBlock, '\0');
  return bytes;
}

std::string TarEnd() { return std::string(1024, '\0'); }

}  // namespace parallax

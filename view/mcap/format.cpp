#include "musher/view/mcap/format.hpp"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "musher/base/check.hpp"

namespace musher::mcap {
namespace {

std::optional<std::string> DecompressLz4(std::string_view data, std::uint64_t size) {
  constexpr std::uint64_t kMostRatio = 255;  // of the format
  if (size > data.size() * kMostRatio) return std::nullopt;
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return std::nullopt;
  std::string out(size, '\0');
  std::size_t done = 0;
  bool good = true;
  std::size_t hint = 1;
  while (good && hint != 0 && !data.empty()) {
    std::size_t room = out.size() - done;
    std::size_t taken = data.size();
    hint = LZ4F_decompress(context, out.data() + done, &room, data.data(), &taken, nullptr);
    good = LZ4F_isError(hint) == 0 && (room > 0 || taken > 0);
    done += room;
    data.remove_prefix(taken);
  }
  LZ4F_freeDecompressionContext(context);
  if (!good || done != size) return std::nullopt;
  return out;
}

}  // namespace

std::string Compress(const std::string& name, std::string_view data) {
  if (name.empty()) return std::string(data);
  const bool lz4 = name == "lz4";
  std::string out(
      lz4 ? LZ4F_compressFrameBound(data.size(), nullptr) : ZSTD_compressBound(data.size()), '\0');
  const std::size_t size =
      lz4 ? LZ4F_compressFrame(out.data(), out.size(), data.data(), data.size(), nullptr)
          : ZSTD_compress(out.data(), out.size(), data.data(), data.size(), 1);
  MUSHER_CHECK(lz4 ? LZ4F_isError(size) == 0 : ZSTD_isError(size) == 0, "the buffer is too small");
  out.resize(size);
  return out;
}

std::optional<std::string> Decompress(std::string_view name, std::string_view data,
                                      std::uint64_t size) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
  if (size > kMost) return std::nullopt;
  if (name.empty()) {
    if (data.size() != size) return std::nullopt;
    return std::string(data);
  }
  if (name == "lz4") return DecompressLz4(data, size);
  if (name != "zstd") return std::nullopt;
  const unsigned long long said = ZSTD_getFrameContentSize(data.data(), data.size());
  if (said == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
  if (said != ZSTD_CONTENTSIZE_UNKNOWN && said != size) return std::nullopt;
  std::string out(size, '\0');
  const std::size_t done = ZSTD_decompress(out.data(), out.size(), data.data(), data.size());
  if (ZSTD_isError(done) != 0 || done != size) return std::nullopt;
  return out;
}

std::uint32_t Crc(std::string_view data, std::uint32_t before) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(data.data()), data.size()));
}

}  // namespace musher::mcap

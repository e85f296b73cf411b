#include "recording/packet_compression.hpp"

#include <memory>

#include "recording/error.hpp"

#ifdef EGOFOCUS_HAVE_LZ4
#include <lz4frame.h>
#endif
#ifdef EGOFOCUS_HAVE_ZSTD
#include <zstd.h>
#endif

namespace egofocus::recording {
namespace {

constexpr std::size_t kStepBytes = 1u << 16;

[[noreturn]] [[maybe_unused]] void refuse(const std::string& where, const std::string& what) {
  throw Error(ExitCode::kBadFile, where, what + " The file is damaged or cut off. Copy or record it again.");
}

/// Grows `out` by one step and says how much there was.
[[maybe_unused]] std::size_t grow(std::vector<std::byte>& out, const std::string& where) {
  const std::size_t before = out.size();
  if (before >= kLargestPacketBytes) refuse(where, "A packet unpacks to more than there can be.");
  out.resize(before + (before < kStepBytes ? kStepBytes : before));
  return before;
}

#ifdef EGOFOCUS_HAVE_LZ4

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

void unpack_lz4(std::span<const std::byte> packed, const std::string& where, std::vector<std::byte>& out) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, FreeLz4> context(made);
  std::size_t used = 0;
  std::size_t left = 1;
  while (left != 0) {
    if (out.size() == used) (void)grow(out, where);
    std::size_t room = out.size() - used;
    std::size_t taken = packed.size();
    left = LZ4F_decompress(context.get(), out.data() + used, &room, packed.data(), &taken, nullptr);
    if (LZ4F_isError(left)) refuse(where, std::string("LZ4: ") + LZ4F_getErrorName(left) + ".");
    used += room;
    packed = packed.subspan(taken);
    if (left != 0 && room == 0 && taken == 0) refuse(where, "LZ4: the frame has no end.");
  }
  out.resize(used);
}

#endif
#ifdef EGOFOCUS_HAVE_ZSTD

struct FreeZstd {
  void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
};

void unpack_zstd(std::span<const std::byte> packed, const std::string& where, std::vector<std::byte>& out) {
  const std::unique_ptr<ZSTD_DStream, FreeZstd> stream(ZSTD_createDStream());
  if (!stream) throw std::bad_alloc();
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t used = 0;
  std::size_t left = 1;
  while (left != 0) {
    if (out.size() == used) (void)grow(out, where);
    ZSTD_outBuffer target{out.data(), out.size(), used};
    const std::size_t taken_before = in.pos;
    left = ZSTD_decompressStream(stream.get(), &target, &in);
    if (ZSTD_isError(left)) refuse(where, std::string("Zstandard: ") + ZSTD_getErrorName(left) + ".");
    if (left != 0 && target.pos == used && in.pos == taken_before)
      refuse(where, "Zstandard: the frame has no end.");
    used = target.pos;
  }
  out.resize(used);
}

#endif

}  // namespace

void unpack(Compression compression, std::span<const std::byte> packed, const std::string& where,
            std::vector<std::byte>& out) {
  out.clear();
  switch (compression) {
    case Compression::kNone:
      out.assign(packed.begin(), packed.end());
      return;
    case Compression::kLz4:
    case Compression::kLz4High:
#ifdef EGOFOCUS_HAVE_LZ4
      return unpack_lz4(packed, where, out);
#else
      throw Error(ExitCode::kFile, where,
                  "is LZ4, and this build has none. Debian: apt-get install liblz4-dev, then build again.");
#endif
    case Compression::kZstd:
    case Compression::kZstdHigh:
#ifdef EGOFOCUS_HAVE_ZSTD
      return unpack_zstd(packed, where, out);
#else
      throw Error(
          ExitCode::kFile, where,
          "is Zstandard, and this build has none. Debian: apt-get install libzstd-dev, then build again.");
#endif
  }
  throw Error(ExitCode::kBadFile, where, "is compressed in an unknown way.");
}

}  // namespace egofocus::recording

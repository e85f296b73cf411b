#include "pipeline/embedded_model.hpp"

#include "egofocus/config.hpp"

#ifdef EGOFOCUS_EMBEDDED_MODEL

// The assembler takes the file as it is: no generated source, and nothing to compile. Model::kAlignment is
// 2^4.
asm(".pushsection .rodata\n"
    ".p2align 4\n"
    ".globl egofocus_model_begin\n"
    ".hidden egofocus_model_begin\n"
    "egofocus_model_begin:\n"
    ".incbin \"" EGOFOCUS_EMBEDDED_MODEL
    "\"\n"
    ".globl egofocus_model_end\n"
    ".hidden egofocus_model_end\n"
    "egofocus_model_end:\n"
    ".popsection\n");

extern "C" const std::byte egofocus_model_begin[];
extern "C" const std::byte egofocus_model_end[];

namespace egofocus {

std::span<const std::byte> embedded_model() noexcept {
  return {egofocus_model_begin, egofocus_model_end};
}

}  // namespace egofocus

#else

namespace egofocus {

std::span<const std::byte> embedded_model() noexcept {
  return {};
}

}  // namespace egofocus

#endif

namespace egofocus {

Backend default_backend() noexcept {
  return embedded_model().empty() ? Backend::kFocus : Backend::kNetwork;
}

}  // namespace egofocus

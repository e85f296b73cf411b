#include "citysim/texture_library.hpp"

#include <array>

namespace egofocus::citysim {
namespace {

struct Stock {
  Pattern pattern;
  int count;
  double low, high;     ///< mean reflectance
  double weak, strong;  ///< contrast
};

// Mean reflectances of common materials: asphalt 0.07-0.2, concrete 0.3-0.5, brick 0.2-0.4, paint 0.4-0.85,
// foliage 0.06-0.2.
constexpr std::array<Stock, 14> kStock{{
    {Pattern::kBlank, 2, 0.25, 0.8, 1.0, 1.0},
    {Pattern::kNoise, 4, 0.1, 0.6, 0.3, 1.2},
    {Pattern::kBlobs, 3, 0.15, 0.6, 0.5, 1.2},
    {Pattern::kStripes, 3, 0.2, 0.6, 0.5, 1.2},
    {Pattern::kBricks, 3, 0.2, 0.45, 0.5, 1.1},
    {Pattern::kTiles, 3, 0.3, 0.7, 0.4, 1.0},
    {Pattern::kText, 4, 0.4, 0.7, 0.8, 1.2},
    {Pattern::kFacade, 7, 0.25, 0.6, 0.6, 1.2},
    {Pattern::kPlanks, 2, 0.2, 0.5, 0.5, 1.0},
    {Pattern::kAsphalt, 3, 0.08, 0.25, 0.35, 0.9},
    {Pattern::kFoliage, 2, 0.07, 0.2, 0.9, 1.5},
    {Pattern::kChecker, 1, 0.35, 0.35, 1.2, 1.2},
    {Pattern::kBooks, 2, 0.3, 0.5, 0.8, 1.2},
    {Pattern::kClouds, 1, 0.5, 0.5, 0.8, 0.8},
}};

}  // namespace

TextureLibrary::TextureLibrary(std::uint64_t seed) {
  for (const Stock& stock : kStock) {
    for (int i = 0; i < stock.count; ++i) {
      Random random(sim::mix_bits(seed + static_cast<std::uint64_t>(entries_.size())), "texture");
      const double mean = random.log_uniform(stock.low, stock.high * 1.0001);
      const double contrast = random.uniform(stock.weak, stock.strong);
      entries_.push_back({stock.pattern, static_cast<int>(entries_.size())});
      const Texture texture = Texture::make(stock.pattern, mean, contrast, random);
      texels_.insert(texels_.end(), texture.texels().begin(), texture.texels().end());
    }
  }
}

int TextureLibrary::pick(Pattern pattern, Random& random) const {
  int count = 0;
  for (const Entry& entry : entries_) count += entry.pattern == pattern;
  int skip = static_cast<int>(random.below(static_cast<std::uint32_t>(count)));
  for (const Entry& entry : entries_) {
    if (entry.pattern == pattern && skip-- == 0) return entry.texture;
  }
  return 0;
}

Surface TextureLibrary::surface(Pattern pattern, double metres, Random& random) const {
  Surface out;
  out.texture = pick(pattern, random);
  out.metres = metres * random.log_uniform(0.75, 1.35);
  const double value = random.log_uniform(0.5, 1.3);
  for (float& channel : out.colour) channel = static_cast<float>(value * random.uniform(0.75, 1.15));
  return out;
}

Surface TextureLibrary::any(double metres, double blank, Random& random) const {
  static constexpr std::array<Pattern, 10> kAny{
      Pattern::kNoise, Pattern::kNoise,  Pattern::kBlobs, Pattern::kStripes, Pattern::kBricks,
      Pattern::kTiles, Pattern::kPlanks, Pattern::kText,  Pattern::kChecker, Pattern::kNoise,
  };
  const std::uint32_t which = random.below(static_cast<std::uint32_t>(kAny.size()));
  const Pattern pattern = random.chance(blank) ? Pattern::kBlank : kAny[which];
  return surface(pattern, metres, random);
}

}  // namespace egofocus::citysim

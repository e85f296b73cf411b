// A stock of surfaces that scenes pick from. Making it takes half a second, so samples share one.
#pragma once

#include <memory>
#include <vector>

#include "citysim/mesh.hpp"
#include "citysim/texture.hpp"

namespace egofocus::citysim {

class TextureLibrary {
 public:
  /// Several textures of each pattern, contrast and brightness varied.
  explicit TextureLibrary(std::uint64_t seed);

  /// All textures one after the other, Texture::kTexels each: texture t begins at t * kTexels.
  [[nodiscard]] const std::uint64_t* texels() const { return texels_.data(); }
  /// Any texture of this pattern.
  [[nodiscard]] int pick(Pattern pattern, Random& random) const;
  /// A surface of this pattern: `metres` one period covers, with a colour drawn around grey.
  [[nodiscard]] Surface surface(Pattern pattern, double metres, Random& random) const;
  /// A wall, piece of furniture or thing: any pattern that such has; blank with probability `blank`.
  [[nodiscard]] Surface any(double metres, double blank, Random& random) const;

 private:
  struct Entry {
    Pattern pattern;
    int texture;
  };
  std::vector<std::uint64_t> texels_;
  std::vector<Entry> entries_;
};

}  // namespace egofocus::citysim

#include "citysim/renderer.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "citysim/clones.hpp"
#include "citysim/raster.hpp"
#include "citysim/shade.hpp"
#include "citysim/view_polygons.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kTileWidth = Optics::kTileWidth;
constexpr int kTileHeight = Optics::kTileHeight;

/// (blur, 1 - 2 blur, blur) along rows into `out`; the border repeats.
CITYSIM_CLONES void blur_row(const float* __restrict in, float* __restrict out, int width, float blur) {
  out[0] = in[0] + blur * (in[1] - in[0]);
  for (int x = 1; x < width - 1; ++x) out[x] = in[x] + blur * ((in[x - 1] - in[x]) + (in[x + 1] - in[x]));
  out[width - 1] = in[width - 1] + blur * (in[width - 2] - in[width - 1]);
}

CITYSIM_CLONES void blur_column(const float* __restrict above, const float* __restrict in,
                                const float* __restrict below, float* __restrict out, int width, float blur) {
  for (int x = 0; x < width; ++x) out[x] = in[x] + blur * ((above[x] - in[x]) + (below[x] - in[x]));
}

/// Of a tile; nearly always a whole one, which is one or two machine words.
template <typename Value>
void copy_row(const Value* from, int columns, Value* to) {
  if (columns == kTileWidth) {
    std::memcpy(to, from, kTileWidth * sizeof(Value));
  } else {
    std::copy_n(from, columns, to);
  }
}

void blur_picture(std::vector<float>& light, std::vector<float>& spare, int width, int height, float blur) {
  spare.resize(light.size());
  const auto row = [width](std::vector<float>& of, int y) {
    return of.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
  };
  for (int y = 0; y < height; ++y) blur_row(row(light, y), row(spare, y), width, blur);
  for (int y = 0; y < height; ++y) {
    blur_column(row(spare, std::max(y - 1, 0)), row(spare, y), row(spare, std::min(y + 1, height - 1)),
                row(light, y), width, blur);
  }
}

}  // namespace

struct RenderScratch::Buffers {
  std::vector<ObjectInSight> objects;
  std::vector<LitPolygon> polygons;
  std::vector<TileHits> hits;
  std::vector<float> spare;
};

RenderScratch::RenderScratch() : buffers_(std::make_unique<Buffers>()) {}
RenderScratch::~RenderScratch() = default;
RenderScratch::RenderScratch(RenderScratch&&) noexcept = default;

Renderer::Renderer(const Scene& scene, const Optics& optics, double blur)
    : scene_(scene), optics_(optics), blur_(static_cast<float>(blur)) {
  const float strength = static_cast<float>(scene.headlight);
  for (int row = 0; row < optics.tiles_down(); ++row) {
    for (int column = 0; column < optics.tiles_across(); ++column) {
      const Optics::Tile& tile = optics.tile(column, row);
      for (int i = 0; i < Optics::kTilePixels; ++i)
        headlight_.push_back(strength * headlight_along(tile.x[i], tile.y[i]));
    }
  }
}

void Renderer::blur(std::vector<float>& light, std::vector<float>& spare) const {
  if (blur_ > 0) blur_picture(light, spare, optics_.width(), optics_.height(), blur_);
}

void Renderer::find_hits(const Pose& camera, double t_s, std::span<const std::uint8_t> wanted,
                         RenderScratch& scratch) const {
  RenderScratch::Buffers& work = *scratch.buffers_;
  std::vector<TileHits>& hits = work.hits;
  const int across = optics_.tiles_across();
  hits.resize(static_cast<std::size_t>(across * optics_.tiles_down()));
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (wanted.empty() || wanted[i]) {
      hits[i].clear();
    } else {
      hits[i].farthest = std::numeric_limits<float>::max();  // nothing can be nearer
    }
  }
  // Near things hide far ones: most of a town is behind its first row of houses.
  const auto hidden = [&](const Optics::TileRange& range, float largest_inverse_depth) {
    for (int row = range.first_row; row <= range.last_row; ++row) {
      for (int column = range.first_column; column <= range.last_column; ++column) {
        if (largest_inverse_depth > hits[static_cast<std::size_t>(row * across + column)].farthest)
          return false;
      }
    }
    return true;
  };

  work.objects.clear();
  objects_in_sight(scene_, camera, t_s, optics_, work.objects);
  work.polygons.clear();
  Outline shape;
  for (std::size_t seen = 0; seen < work.objects.size(); ++seen) {
    const ObjectInSight& object = work.objects[seen];
    if (hidden(object.tiles, object.largest_inverse_depth)) continue;
    for (const Polygon& polygon : scene_.objects[static_cast<std::size_t>(object.object)].polygons) {
      if (!outline(polygon, object.to_camera, optics_, shape)) continue;
      if (hidden(shape.tiles, shape.largest_inverse_depth)) continue;
      const std::int32_t index = static_cast<std::int32_t>(work.polygons.size());
      LitPolygon& lit = work.polygons.emplace_back();
      lit.shape = view_polygon(polygon, shape);
      lit.shape.in_sight = static_cast<std::int32_t>(seen);
      lit.shape.object = object.object;
      for (int row = shape.tiles.first_row; row <= shape.tiles.last_row; ++row) {
        for (int column = shape.tiles.first_column; column <= shape.tiles.last_column; ++column) {
          TileHits& tile = hits[static_cast<std::size_t>(row * across + column)];
          if (shape.largest_inverse_depth <= tile.farthest) continue;
          raster(lit.shape, index, optics_.tile(column, row), tile);
        }
      }
    }
  }
}

void Renderer::render(const Pose& camera, double t_s, RenderScratch& scratch, View& view,
                      const RenderOptions& options) const {
  find_hits(camera, t_s, options.tiles, scratch);
  const bool colour = options.colour;
  RenderScratch::Buffers& work = *scratch.buffers_;
  const int across = optics_.tiles_across();
  const int down = optics_.tiles_down();
  const int width = optics_.width();
  const int height = optics_.height();
  const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const bool flickers = scene_.flicker_depth > 0;
  view.light.resize(size);
  view.mains.resize(flickers ? size : 0);
  view.inverse_depth.resize(size);
  view.object.resize(size);
  view.colour.resize(colour ? size : 0);
  ShadeMoment moment;
  moment.scene = &scene_;
  moment.world_from_camera = camera.rotation;
  moment.flicker = static_cast<float>(scene_.flicker_at(t_s));
  moment.pixels_per_unit = static_cast<float>(optics_.camera().intrinsics.fx_px);
  TileLooks looks;
  Colour colours[Optics::kTilePixels];
  for (int row = 0; row < down; ++row) {
    for (int column = 0; column < across; ++column) {
      const std::size_t number = static_cast<std::size_t>(row * across + column);
      if (!options.tiles.empty() && !options.tiles[number]) continue;
      const TileHits& tile = work.hits[number];
      shade(moment, work.objects, work.polygons, optics_.tile(column, row),
            &headlight_[number * static_cast<std::size_t>(Optics::kTilePixels)], tile, looks,
            colour ? colours : nullptr);
      const int columns = std::min(kTileWidth, width - column * kTileWidth);
      const int rows = std::min(kTileHeight, height - row * kTileHeight);
      for (int y = 0; y < rows; ++y) {
        const std::size_t to =
            static_cast<std::size_t>((row * kTileHeight + y) * width + column * kTileWidth);
        const int from = y * kTileWidth;
        copy_row(looks.light + from, columns, &view.light[to]);
        if (flickers) copy_row(looks.mains + from, columns, &view.mains[to]);
        copy_row(tile.inverse_depth + from, columns, &view.inverse_depth[to]);
        copy_row(looks.object + from, columns, &view.object[to]);
        if (colour) std::copy_n(colours + from, columns, &view.colour[to]);
      }
    }
  }
  if (!options.blur) return;
  blur(view.light, work.spare);
  if (flickers) blur(view.mains, work.spare);
}

}  // namespace egofocus::citysim

#include "citysim/renderer.hpp"

#include <algorithm>

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
  std::vector<ViewPolygon> polygons;
  std::vector<TileHits> hits;
  std::vector<float> spare;
};

RenderScratch::RenderScratch() : buffers_(std::make_unique<Buffers>()) {}
RenderScratch::~RenderScratch() = default;
RenderScratch::RenderScratch(RenderScratch&&) noexcept = default;

Renderer::Renderer(const Scene& scene, const Optics& optics, double blur)
    : scene_(scene), optics_(optics), blur_(static_cast<float>(blur)) {}

void Renderer::render(const Pose& camera, double t_s, RenderScratch& scratch, View& view, bool colour) const {
  RenderScratch::Buffers& work = *scratch.buffers_;
  std::vector<ViewPolygon>& polygons = work.polygons;
  std::vector<TileHits>& hits = work.hits;
  const int across = optics_.tiles_across();
  const int down = optics_.tiles_down();
  hits.resize(static_cast<std::size_t>(across * down));
  for (TileHits& tile : hits) tile.clear();
  const auto for_tiles = [&](const Optics::TileRange& range, auto&& body) {
    for (int row = range.first_row; row <= range.last_row; ++row) {
      for (int column = range.first_column; column <= range.last_column; ++column) {
        body(hits[static_cast<std::size_t>(row * across + column)], optics_.tile(column, row));
      }
    }
  };

  work.objects.clear();
  objects_in_sight(scene_, camera, t_s, optics_, work.objects);
  polygons.clear();
  for (const ObjectInSight& object : work.objects) {
    // Near things hide far ones: most of a town is behind its first row of houses.
    bool hidden = true;
    for_tiles(object.tiles, [&](const TileHits& tile, const Optics::Tile&) {
      hidden = hidden && object.largest_inverse_depth <= tile.farthest;
    });
    if (hidden) continue;
    const std::size_t first = polygons.size();
    view_polygons(scene_, object, optics_, polygons);
    for (std::size_t k = first; k < polygons.size(); ++k) {
      const ViewPolygon& polygon = polygons[k];
      for_tiles(optics_.tiles_in(polygon.low_x, polygon.high_x, polygon.low_y, polygon.high_y),
                [&](TileHits& tile, const Optics::Tile& rays) {
                  if (polygon.largest_inverse_depth <= tile.farthest) return;
                  raster(polygon, static_cast<std::int32_t>(k), rays, tile);
                });
    }
  }

  const int width = optics_.width();
  const int height = optics_.height();
  const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  view.light.resize(size);
  view.inverse_depth.resize(size);
  view.object.resize(size);
  view.colour.resize(colour ? size : 0);
  ShadeMoment moment;
  moment.scene = &scene_;
  moment.world_from_camera = camera.rotation;
  moment.flicker = static_cast<float>(scene_.flicker_at(t_s));
  moment.pixels_per_unit = static_cast<float>(optics_.camera().intrinsics.fx_px);
  for (int row = 0; row < down; ++row) {
    for (int column = 0; column < across; ++column) {
      const TileHits& tile = hits[static_cast<std::size_t>(row * across + column)];
      float light[Optics::kTilePixels];
      Colour colours[Optics::kTilePixels];
      shade(moment, polygons, optics_.tile(column, row), tile, light, colour ? colours : nullptr);
      const int columns = std::min(kTileWidth, width - column * kTileWidth);
      const int rows = std::min(kTileHeight, height - row * kTileHeight);
      for (int y = 0; y < rows; ++y) {
        const std::size_t to =
            static_cast<std::size_t>((row * kTileHeight + y) * width + column * kTileWidth);
        for (int x = 0; x < columns; ++x) {
          const int from = y * kTileWidth + x;
          const std::size_t at = to + static_cast<std::size_t>(x);
          const std::int32_t polygon = tile.polygon[from];
          view.light[at] = light[from];
          view.inverse_depth[at] = tile.inverse_depth[from];
          view.object[at] = polygon < 0 ? -1 : polygons[static_cast<std::size_t>(polygon)].object;
          if (colour) view.colour[at] = colours[from];
        }
      }
    }
  }
  if (blur_ > 0) blur_picture(view.light, work.spare, width, height, blur_);
}

}  // namespace egofocus::citysim

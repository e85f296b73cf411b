#include "citysim/shade.hpp"

#include <algorithm>
#include <bit>

#include "citysim/clones.hpp"
#include "citysim/texture_library.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kPixels = Optics::kTilePixels;

/// Per ray: texture coordinates in texels, level of detail, light that falls on the surface.
struct Ground {
  alignas(64) float u[kPixels];
  alignas(64) float v[kPixels];
  alignas(64) float level[kPixels];
  alignas(64) float light[kPixels];
};

struct Beam {
  float headlight;
  float flicker;
  float pixel;  ///< angle of a pixel
};

/// Light of the robot's own lamps: a soft cone around the optical axis, a little below it.
inline float beam(float x, float y) {
  const float a = x * (1.0f / 0.55f);
  const float b = (y - 0.12f) * (1.0f / 0.3f);
  return 1.0f / (1.0f + a * a * a * a + b * b * b * b);
}

/// log2, linear between powers of two: continuous, which is all that a texture level needs.
inline float rough_log2(float x) {
  return static_cast<float>(std::bit_cast<std::int32_t>(x)) * (1.0f / 8388608.0f) - 127.0f;
}

CITYSIM_CLONES void ground(const ViewPolygon& p, std::int32_t index, const Beam& lamp, int first, int last,
                           const float* __restrict xs, const float* __restrict ys,
                           const float* __restrict depths, const std::int32_t* __restrict polygons,
                           Ground& out) {
  const RayAffine pu = p.u;
  const RayAffine pv = p.v;
  const RayAffine ps = p.steady;
  const RayAffine pf = p.flickering;
  const RayPlane pd = p.inverse_depth;
  const float facing = p.facing;
  for (int i = first; i < last; ++i) {
    const float x = xs[i];
    const float y = ys[i];
    const float rho = depths[i] > 1e-6f ? depths[i] : 1e-6f;
    const float z = 1.0f / rho;
    const float wu = pu.x * x + pu.y * y + pu.one;
    const float wv = pv.x * x + pv.y * y + pv.one;
    // d(w z)/dx = z (w_x - w z rho_x), with z = 1 / rho.
    const float ux = z * (pu.x - wu * z * pd.x);
    const float uy = z * (pu.y - wu * z * pd.y);
    const float vx = z * (pv.x - wv * z * pd.x);
    const float vy = z * (pv.y - wv * z * pd.y);
    const float along = ux * ux + vx * vx;
    const float down = uy * uy + vy * vy;
    // Between the long and the short side of a pixel's footprint: neither blur nor flicker wins.
    const float area = ux * vy - uy * vx;
    const float longest = along > down ? along : down;
    const float square = (area < 0 ? -area : area) + 0.25f * longest;
    const float level = 0.5f * rough_log2(square * (lamp.pixel * lamp.pixel) + 1e-12f);
    float light = (ps.x * x + ps.y * y + ps.one) * z + ps.offset;
    light += lamp.flicker * ((pf.x * x + pf.y * y + pf.one) * z + pf.offset);
    const float ray2 = 1.0f + x * x + y * y;
    const float near2 = rho * rho < 1.0f ? rho * rho : 1.0f;
    light += lamp.headlight * beam(x, y) * (facing * rho) * near2 / (ray2 * ray2);
    const bool mine = polygons[i] == index;
    out.u[i] = mine ? wu * z + pu.offset : out.u[i];
    out.v[i] = mine ? wv * z + pv.offset : out.v[i];
    out.level[i] = mine ? level : out.level[i];
    out.light[i] = mine ? (light > 0 ? light : 0.0f) : out.light[i];
  }
}

inline float bilinear(const Texture& texture, int level, float u, float v) {
  const int side = Texture::kSide >> level;
  const float scale = 1.0f / static_cast<float>(1 << level);
  const float x = u * scale - 0.5f;
  const float y = v * scale - 0.5f;
  int x0 = static_cast<int>(x);
  int y0 = static_cast<int>(y);
  x0 -= x < static_cast<float>(x0);
  y0 -= y < static_cast<float>(y0);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const int mask = side - 1;
  const std::uint16_t* at = texture.level(level);
  const std::uint16_t* row0 = at + (y0 & mask) * side;
  const std::uint16_t* row1 = at + ((y0 + 1) & mask) * side;
  const int a = x0 & mask;
  const int b = (x0 + 1) & mask;
  const float top = static_cast<float>(row0[a]) + fx * static_cast<float>(row0[b] - row0[a]);
  const float bottom = static_cast<float>(row1[a]) + fx * static_cast<float>(row1[b] - row1[a]);
  return (top + fy * (bottom - top)) * (1.0f / 65535.0f);
}

inline float trilinear(const Texture& texture, float level, float u, float v) {
  level = std::clamp(level, 0.0f, static_cast<float>(Texture::kLevels - 2));
  const int fine = static_cast<int>(level);
  const float part = level - static_cast<float>(fine);
  const float sharp = bilinear(texture, fine, u, v);
  if (part < 0.02f) return sharp;
  return sharp + part * (bilinear(texture, fine + 1, u, v) - sharp);
}

float sky_light(const ShadeMoment& moment, float x, float y) {
  const Sky& sky = moment.scene->sky;
  if (sky.indoors) return 0.02f;
  const Vec3 d = moment.world_from_camera * Vec3{static_cast<double>(x), static_cast<double>(y), 1.0};
  const double length = square_root(dot(d, d));
  const double up = std::max(0.0, d[2] / length);
  double light = sky.horizon + (sky.zenith - sky.horizon) * up;
  if (sky.texture >= 0 && up > 0.01) {
    const double scale = 60.0 / (up + 0.1);  // texels: a flat layer of clouds, finite at the horizon
    const float cloud =
        trilinear(moment.scene->library->textures()[static_cast<std::size_t>(sky.texture)], 1.0f,
                  static_cast<float>(scale * d[0] / length), static_cast<float>(scale * d[1] / length));
    light *= 1.0 + sky.clouds * (2.0 * static_cast<double>(cloud) - 1.0);
  }
  return static_cast<float>(light);
}

}  // namespace

void shade(const ShadeMoment& moment, std::span<const ViewPolygon> polygons, const Optics::Tile& tile,
           const TileHits& hits, float* light, Colour* colour) {
  const Scene& scene = *moment.scene;
  Ground on;
  const Beam lamp{static_cast<float>(scene.headlight), moment.flicker, 1.0f / moment.pixels_per_unit};
  // Each polygon once, over the span of rays that meet it.
  std::int32_t seen[kPixels];
  int first[kPixels];
  int last[kPixels];
  int count = 0;
  for (int i = 0; i < kPixels; ++i) {
    const std::int32_t index = hits.polygon[i];
    if (index < 0) continue;
    int k = count - 1;
    while (k >= 0 && seen[k] != index) --k;
    if (k < 0) {
      k = count++;
      seen[k] = index;
      first[k] = i;
    }
    last[k] = i + 1;
  }
  for (int k = 0; k < count; ++k) {
    ground(polygons[static_cast<std::size_t>(seen[k])], seen[k], lamp, first[k], last[k], tile.x, tile.y,
           hits.inverse_depth, hits.polygon, on);
  }
  const std::vector<Texture>& textures = scene.library->textures();
  const float haze_m = static_cast<float>(scene.sky.haze_m);
  const float haze_light = static_cast<float>(scene.sky.horizon);
  for (int i = 0; i < kPixels; ++i) {
    if (hits.polygon[i] < 0) {
      light[i] = sky_light(moment, tile.x[i], tile.y[i]);
      if (colour != nullptr) colour[i] = {0.8f * light[i], 0.9f * light[i], light[i]};
      continue;
    }
    const Polygon& surface = *polygons[static_cast<std::size_t>(hits.polygon[i])].polygon;
    const float reflectance =
        trilinear(textures[static_cast<std::size_t>(surface.texture)], on.level[i], on.u[i], on.v[i]);
    float clear = reflectance * (on.light[i] + surface.emission);
    float veil = 0;
    if (haze_m > 0) {
      const float share = 1.0f / (1.0f + haze_m * hits.inverse_depth[i]);
      clear *= 1.0f - share;
      veil = share * haze_light;
    }
    const Colour& c = surface.colour;
    light[i] = (0.30f * c[0] + 0.59f * c[1] + 0.11f * c[2]) * clear + veil;
    if (colour != nullptr) colour[i] = {c[0] * clear + veil, c[1] * clear + veil, c[2] * clear + veil};
  }
}

}  // namespace egofocus::citysim

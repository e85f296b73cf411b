#include "citysim/shade.hpp"

#include <algorithm>
#include <bit>

#include "citysim/clones.hpp"
#include "citysim/texture_library.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kPixels = Optics::kTilePixels;

/// Per ray: where its texture is, and how its value becomes light: light = value * gain + veil.
struct Looks {
  alignas(64) float u[kPixels];  ///< texels of the finest level
  alignas(64) float v[kPixels];
  alignas(64) float level[kPixels];  ///< of detail
  alignas(64) float gain[kPixels];   ///< here: light that falls on the surface, until surfaces() is done
  alignas(64) float veil[kPixels];
  alignas(64) std::uint32_t base[kPixels];  ///< the texture's first texel
  alignas(64) float value[kPixels];
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
                           Looks& out) {
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
    out.gain[i] = mine ? (light > 0 ? light : 0.0f) : out.gain[i];
  }
}

/// Bilinear in one level. `texels` as in Texture.
inline float bilinear(const std::uint32_t* __restrict texels, std::uint32_t base, std::int32_t level, float u,
                      float v) {
  const std::int32_t side = Texture::kSide >> level;
  const std::int32_t mask = side - 1;
  const float scale = std::bit_cast<float>((127 - level) << 23);  // 2^-level
  const float x = u * scale - 0.5f;
  const float y = v * scale - 0.5f;
  std::int32_t x0 = static_cast<std::int32_t>(x);
  std::int32_t y0 = static_cast<std::int32_t>(y);
  x0 -= x < static_cast<float>(x0) ? 1 : 0;
  y0 -= y < static_cast<float>(y0) ? 1 : 0;
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const std::int32_t start =
      static_cast<std::int32_t>(base + Texture::offset(static_cast<std::uint32_t>(level)));
  const std::uint32_t above = texels[start + (y0 & mask) * side + (x0 & mask)];
  const std::uint32_t below = texels[start + ((y0 + 1) & mask) * side + (x0 & mask)];
  const float a = static_cast<float>(static_cast<std::int32_t>(above & 0xffff));
  const float b = static_cast<float>(static_cast<std::int32_t>(above >> 16));
  const float c = static_cast<float>(static_cast<std::int32_t>(below & 0xffff));
  const float d = static_cast<float>(static_cast<std::int32_t>(below >> 16));
  const float top = a + fx * (b - a);
  const float bottom = c + fx * (d - c);
  return top + fy * (bottom - top);
}

/// Trilinear texture values of all rays of a tile.
CITYSIM_CLONES void look_up(const std::uint32_t* __restrict texels, Looks& looks) {
  for (int i = 0; i < kPixels; ++i) {
    constexpr float kLast = static_cast<float>(Texture::kLevels - 2);
    float level = looks.level[i];
    level = level > 0 ? level : 0.0f;
    level = level < kLast ? level : kLast;
    const std::int32_t fine = static_cast<std::int32_t>(level);
    const float part = level - static_cast<float>(fine);
    const float sharp = bilinear(texels, looks.base[i], fine, looks.u[i], looks.v[i]);
    const float soft = bilinear(texels, looks.base[i], fine + 1, looks.u[i], looks.v[i]);
    looks.value[i] = (sharp + part * (soft - sharp)) * (1.0f / 65535.0f);
  }
}

constexpr std::uint32_t base_of(int texture) {
  return static_cast<std::uint32_t>(texture) * static_cast<std::uint32_t>(Texture::kTexels);
}

/// The sky along the ray (x, y, 1): brighter or darker upwards, under a flat layer of clouds.
void look_at_sky(const ShadeMoment& moment, float x, float y, int i, Looks& looks) {
  const Sky& sky = moment.scene->sky;
  looks.u[i] = looks.v[i] = looks.level[i] = looks.gain[i] = 0;
  looks.base[i] = base_of(sky.texture < 0 ? 0 : sky.texture);
  if (sky.indoors) {
    looks.veil[i] = 0.02f;
    return;
  }
  const Vec3 d = moment.world_from_camera * Vec3{static_cast<double>(x), static_cast<double>(y), 1.0};
  const double length = square_root(dot(d, d));
  const double up = std::max(0.0, d[2] / length);
  const double light = sky.horizon + (sky.zenith - sky.horizon) * up;
  const double clouds = sky.texture >= 0 ? sky.clouds : 0.0;
  const double scale = 60.0 / ((up + 0.1) * length);  // texels; finite at the horizon
  looks.u[i] = static_cast<float>(scale * d[0]);
  looks.v[i] = static_cast<float>(scale * d[1]);
  looks.level[i] = 1.0f;
  looks.gain[i] = static_cast<float>(2.0 * clouds * light);
  looks.veil[i] = static_cast<float>((1.0 - clouds) * light);
}

}  // namespace

void shade(const ShadeMoment& moment, std::span<const ViewPolygon> polygons, const Optics::Tile& tile,
           const TileHits& hits, float* light, Colour* colour) {
  const Scene& scene = *moment.scene;
  Looks looks;
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
           hits.inverse_depth, hits.polygon, looks);
  }
  const float haze_m = static_cast<float>(scene.sky.haze_m);
  const float haze_light = static_cast<float>(scene.sky.horizon);
  for (int i = 0; i < kPixels; ++i) {
    if (hits.polygon[i] < 0) {
      look_at_sky(moment, tile.x[i], tile.y[i], i, looks);
      continue;
    }
    const Polygon& surface = *polygons[static_cast<std::size_t>(hits.polygon[i])].polygon;
    const float share = haze_m > 0 ? 1.0f / (1.0f + haze_m * hits.inverse_depth[i]) : 0.0f;
    looks.base[i] = base_of(surface.texture);
    looks.gain[i] = (looks.gain[i] + surface.emission) * (1.0f - share);
    looks.veil[i] = share * haze_light;
  }
  look_up(scene.library->texels(), looks);
  for (int i = 0; i < kPixels; ++i) {
    const float clear = looks.value[i] * looks.gain[i];
    static constexpr Colour kSky{0.85f, 1.0f, 1.15f};
    const bool sky = hits.polygon[i] < 0;
    const Colour& c = sky ? kSky : polygons[static_cast<std::size_t>(hits.polygon[i])].polygon->colour;
    const float grey = sky ? 1.0f : 0.30f * c[0] + 0.59f * c[1] + 0.11f * c[2];
    light[i] = grey * clear + looks.veil[i];
    if (colour == nullptr) continue;
    const float white = sky ? 0.0f : looks.veil[i];
    for (std::size_t k = 0; k < 3; ++k) colour[i][k] = c[k] * (sky ? light[i] : clear) + white;
  }
}

}  // namespace egofocus::citysim

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
  alignas(64) float level[kPixels];         ///< of detail
  alignas(64) std::uint32_t base[kPixels];  ///< the texture's first texel
  alignas(64) float gain[kPixels];
  alignas(64) float mains[kPixels];  ///< what flickers of the gain, at its mean
  alignas(64) float veil[kPixels];
  alignas(64) float value[kPixels];
};

struct Moment {
  float flicker;
  float pixel;  ///< angle of a pixel
  float haze_m;
  float haze_light;
};

/// Of one polygon.
struct Paint {
  std::uint32_t base;
  float grey;
  float emission;
  std::int32_t object;
};

/// log2, linear between powers of two: continuous, which is all that a texture level needs.
inline float rough_log2(float x) {
  return static_cast<float>(std::bit_cast<std::int32_t>(x)) * (1.0f / 8388608.0f) - 127.0f;
}

CITYSIM_CLONES void surface(const LitPolygon& p, const Paint& paint, std::int32_t index, const Moment& moment,
                            int first, int last, const float* __restrict xs, const float* __restrict ys,
                            const float* __restrict headlight, const float* __restrict depths,
                            const std::int32_t* __restrict polygons, Looks& __restrict out,
                            std::int32_t* __restrict objects) {
  const RayAffine pu = p.surface.u;
  const RayAffine pv = p.surface.v;
  const RayAffine ps = p.surface.steady;
  const RayAffine pf = p.surface.flickering;
  const RayPlane pd = p.shape.inverse_depth;
  const float facing = p.shape.facing;
  const Paint of = paint;
  const Moment at = moment;
  const float hazy = at.haze_m > 0 ? 1.0f : 0.0f;
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
    const float level = 0.5f * rough_log2(square * (at.pixel * at.pixel) + 1e-12f);
    const float near2 = rho * rho < 1.0f ? rho * rho : 1.0f;
    float steady = (ps.x * x + ps.y * y + ps.one) * z + ps.offset;
    steady = (steady > 0 ? steady : 0.0f) + headlight[i] * (facing * rho) * near2 + of.emission;
    float mains = (pf.x * x + pf.y * y + pf.one) * z + pf.offset;
    mains = mains > 0 ? mains : 0.0f;
    const float share = hazy / (1.0f + at.haze_m * rho);
    const float clear = of.grey * (1.0f - share);
    const bool mine = polygons[i] == index;
    out.u[i] = mine ? wu * z + pu.offset : out.u[i];
    out.v[i] = mine ? wv * z + pv.offset : out.v[i];
    out.level[i] = mine ? level : out.level[i];
    out.gain[i] = mine ? clear * (steady + at.flicker * mains) : out.gain[i];
    out.mains[i] = mine ? clear * mains : out.mains[i];
    out.veil[i] = mine ? share * at.haze_light : out.veil[i];
    out.base[i] = mine ? of.base : out.base[i];
    objects[i] = mine ? of.object : objects[i];
  }
}

/// The sky as it is seen along a ray: brighter or darker upwards, under a flat layer of clouds.
struct Heaven {
  float east[3];  ///< rows of the rotation from the camera to the world
  float north[3];
  float up[3];
  float horizon;
  float rise;    ///< of the light from the horizon to the zenith
  float clouds;  ///< share of the light that the cloud texture modulates
  std::uint32_t base;
};

CITYSIM_CLONES void sky(const Heaven& heaven, const float* __restrict xs, const float* __restrict ys,
                        const float* __restrict per_length, const std::int32_t* __restrict polygons,
                        Looks& __restrict out, std::int32_t* __restrict objects) {
  const Heaven h = heaven;
  for (int i = 0; i < kPixels; ++i) {
    const float x = xs[i];
    const float y = ys[i];
    const float risen = (h.up[0] * x + h.up[1] * y + h.up[2]) * per_length[i];
    const float up = risen > 0 ? risen : 0.0f;
    const float light = h.horizon + h.rise * up;
    const float scale = 60.0f * per_length[i] / (up + 0.1f);  // texels; finite at the horizon
    const bool mine = polygons[i] < 0;
    out.u[i] = mine ? scale * (h.east[0] * x + h.east[1] * y + h.east[2]) : out.u[i];
    out.v[i] = mine ? scale * (h.north[0] * x + h.north[1] * y + h.north[2]) : out.v[i];
    out.level[i] = mine ? 1.0f : out.level[i];
    out.gain[i] = mine ? 2.0f * h.clouds * light : out.gain[i];
    out.mains[i] = mine ? 0.0f : out.mains[i];
    out.veil[i] = mine ? (1.0f - h.clouds) * light : out.veil[i];
    out.base[i] = mine ? h.base : out.base[i];
    objects[i] = mine ? -1 : objects[i];
  }
}

/// Bilinear in one level. `texels` as in Texture.
inline float bilinear(const std::uint64_t* __restrict texels, std::uint32_t base, std::int32_t level, float u,
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
  const std::uint64_t four = texels[start + (y0 & mask) * side + (x0 & mask)];
  const auto upper = static_cast<std::uint32_t>(four);
  const auto lower = static_cast<std::uint32_t>(four >> 32);
  const float a = static_cast<float>(static_cast<std::int32_t>(upper & 0xffff));
  const float b = static_cast<float>(static_cast<std::int32_t>(upper >> 16));
  const float c = static_cast<float>(static_cast<std::int32_t>(lower & 0xffff));
  const float d = static_cast<float>(static_cast<std::int32_t>(lower >> 16));
  const float top = a + fx * (b - a);
  const float bottom = c + fx * (d - c);
  return top + fy * (bottom - top);
}

/// Trilinear texture values of all rays of a tile, and their light.
CITYSIM_CLONES void look_up(const std::uint64_t* __restrict texels, Looks& __restrict looks,
                            float* __restrict light, float* __restrict mains) {
  for (int i = 0; i < kPixels; ++i) {
    constexpr float kLast = static_cast<float>(Texture::kLevels - 2);
    float level = looks.level[i];
    level = level > 0 ? level : 0.0f;
    level = level < kLast ? level : kLast;
    const std::int32_t fine = static_cast<std::int32_t>(level);
    const float part = level - static_cast<float>(fine);
    const float sharp = bilinear(texels, looks.base[i], fine, looks.u[i], looks.v[i]);
    const float soft = bilinear(texels, looks.base[i], fine + 1, looks.u[i], looks.v[i]);
    const float value = (sharp + part * (soft - sharp)) * (1.0f / 65535.0f);
    looks.value[i] = value;
    light[i] = value * looks.gain[i] + looks.veil[i];
    mains[i] = value * looks.mains[i];
  }
}

constexpr std::uint32_t base_of(int texture) {
  return static_cast<std::uint32_t>(texture) * static_cast<std::uint32_t>(Texture::kTexels);
}

Heaven heaven_of(const ShadeMoment& moment) {
  const Sky& sky = moment.scene->sky;
  Heaven h{};
  for (std::size_t k = 0; k < 3; ++k) {
    h.east[k] = static_cast<float>(moment.world_from_camera[0][k]);
    h.north[k] = static_cast<float>(moment.world_from_camera[1][k]);
    h.up[k] = static_cast<float>(moment.world_from_camera[2][k]);
  }
  h.horizon = sky.indoors ? 0.02f : static_cast<float>(sky.horizon);
  h.rise = sky.indoors ? 0.0f : static_cast<float>(sky.zenith - sky.horizon);
  h.clouds = sky.indoors || sky.texture < 0 ? 0.0f : static_cast<float>(sky.clouds);
  h.base = base_of(std::max(sky.texture, 0));
  return h;
}

float grey_of(const Colour& colour) {
  return 0.30f * colour[0] + 0.59f * colour[1] + 0.11f * colour[2];
}

/// Light is grey; a surface's own share of it, without haze, is tinted by its colour.
void tint(std::span<const LitPolygon> polygons, const TileHits& hits, const Looks& looks, Colour* colour) {
  static constexpr Colour kSky{0.85f, 1.0f, 1.15f};
  for (int i = 0; i < kPixels; ++i) {
    const float clear = looks.value[i] * looks.gain[i];
    if (hits.polygon[i] < 0) {
      for (std::size_t k = 0; k < 3; ++k) colour[i][k] = kSky[k] * (clear + looks.veil[i]);
      continue;
    }
    const Colour& c = polygons[static_cast<std::size_t>(hits.polygon[i])].shape.polygon->colour;
    const float per_grey = clear / std::max(grey_of(c), 1e-6f);
    for (std::size_t k = 0; k < 3; ++k) colour[i][k] = c[k] * per_grey + looks.veil[i];
  }
}

}  // namespace

float headlight_along(float x, float y) {
  const float a = x * (1.0f / 0.55f);
  const float b = (y - 0.12f) * (1.0f / 0.3f);
  const float ray2 = 1.0f + x * x + y * y;
  return 1.0f / ((1.0f + a * a * a * a + b * b * b * b) * (ray2 * ray2));
}

void shade(const ShadeMoment& moment, std::span<const ObjectInSight> in_sight, std::span<LitPolygon> polygons,
           const Optics::Tile& tile, const float* headlight, const TileHits& hits, TileLooks& out,
           Colour* colour) {
  const Scene& scene = *moment.scene;
  Looks looks;
  // Each polygon once, over the span of rays that meet it.
  std::int32_t seen[kPixels];
  int first[kPixels];
  int last[kPixels];
  int count = 0;
  bool has_sky = false;
  for (int i = 0; i < kPixels;) {
    const std::int32_t index = hits.polygon[i];
    const int begin = i;
    while (i < kPixels && hits.polygon[i] == index) ++i;
    if (index < 0) {
      has_sky = true;
      continue;
    }
    int k = count - 1;
    while (k >= 0 && seen[k] != index) --k;
    if (k < 0) {
      k = count++;
      seen[k] = index;
      first[k] = begin;
    }
    last[k] = i;
  }
  const Moment now{moment.flicker, 1.0f / moment.pixels_per_unit, static_cast<float>(scene.sky.haze_m),
                   static_cast<float>(scene.sky.horizon)};
  for (int k = 0; k < count; ++k) {
    LitPolygon& lit = polygons[static_cast<std::size_t>(seen[k])];
    const Polygon& polygon = *lit.shape.polygon;
    if (!lit.has_surface) {
      lit.surface = view_surface(polygon, in_sight[static_cast<std::size_t>(lit.shape.in_sight)].to_camera);
      lit.has_surface = true;
    }
    const Paint paint{base_of(polygon.texture), grey_of(polygon.colour), polygon.emission, lit.shape.object};
    surface(lit, paint, seen[k], now, first[k], last[k], tile.x, tile.y, headlight, hits.inverse_depth,
            hits.polygon, looks, out.object);
  }
  if (has_sky) sky(heaven_of(moment), tile.x, tile.y, tile.per_length, hits.polygon, looks, out.object);
  look_up(scene.library->texels(), looks, out.light, out.mains);
  if (colour != nullptr) tint(polygons, hits, looks, colour);
}

}  // namespace egofocus::citysim

#include "citysim/indoors.hpp"

namespace egofocus::citysim {

void add_wall(Mesh& mesh, const Vec3& a, const Vec3& b, double height_a, double height_b,
              const Surface& surface) {
  mesh.quad(a, b, b + Vec3{0, 0, height_b}, a + Vec3{0, 0, height_a}, surface);
}

void add_panel(Mesh& mesh, const Place& place, double width, double height, const Surface& surface) {
  const auto p = [&](double x, double z) { return place.point(x, 0.02, z); };
  mesh.quad(p(-0.5 * width, 0), p(0.5 * width, 0), p(0.5 * width, height), p(-0.5 * width, height), surface);
}

Surface panel_surface(const TextureLibrary& library, Random& random) {
  Surface panel =
      random.chance(0.3) ? library.surface(Pattern::kFacade, 1.8, random) : library.any(1.2, 0.15, random);
  if (random.chance(0.15)) panel.emission = static_cast<float>(random.log_uniform(0.2, 1.5));
  return panel;
}

void light_indoors(Scene& scene, double least_ambient, double most_ambient, Random& random) {
  scene.flicker_depth = random.chance(0.4) ? random.uniform(0.02, 0.2) : 0.0;
  scene.sky.indoors = true;
  scene.sky.sun = 0;
  scene.sky.ambient = random.log_uniform(least_ambient, most_ambient);
  finish_scene(scene);
}

}  // namespace egofocus::citysim

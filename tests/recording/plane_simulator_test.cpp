#include "support/plane_simulator.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

using namespace egofocus;
using namespace egofocus::sim;

namespace {

/// The motion field in normalised coordinates: velocity of the picture of a static point.
Ray motion_field(Ray p, double depth_m, const Twist& twist) {
  const Vec3& t = twist.velocity_m_s;
  const Vec3& w = twist.rate_rad_s;
  return {(-t[0] + p.x * t[2]) / depth_m + p.x * p.y * w[0] - (1 + p.x * p.x) * w[1] + p.y * w[2],
          (-t[1] + p.y * t[2]) / depth_m + (1 + p.y * p.y) * w[0] - p.x * p.y * w[1] - p.x * w[2]};
}

std::size_t count_between(const std::vector<Event>& events, std::int64_t from_us, std::int64_t to_us) {
  return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [=](const Event& event) {
    return event.t_us >= from_us && event.t_us < to_us;
  }));
}

}  // namespace

TEST_CASE("pixel rays undo the distortion") {
  const CameraModel camera = PlaneSimulator().camera().config.camera;
  const std::vector<Ray> rays = pixel_rays(camera);
  const double* c = camera.coefficients;
  for (std::int32_t v = 0; v < 180; v += 7) {
    for (std::int32_t u = 0; u < 240; u += 7) {
      const Ray r = rays[static_cast<std::size_t>(v * 240 + u)];
      const double r2 = r.x * r.x + r.y * r.y;
      const double radial = 1 + c[0] * r2 + c[1] * r2 * r2;
      const double x = r.x * radial + 2 * c[2] * r.x * r.y + c[3] * (r2 + 2 * r.x * r.x);
      const double y = r.y * radial + c[2] * (r2 + 2 * r.y * r.y) + 2 * c[3] * r.x * r.y;
      CHECK(x * camera.intrinsics.fx_px + camera.intrinsics.cx_px == Approx(u).margin(1e-9));
      CHECK(y * camera.intrinsics.fy_px + camera.intrinsics.cy_px == Approx(v).margin(1e-9));
    }
  }
}

TEST_CASE("the depth of a slanted plane is the analytic one") {
  // Seen from the origin along world x. The plane x = 3 + 0.5 y + 0.25 z, in camera coordinates (x right = -y
  // world, y down = -z world): Z = 3 - 0.5 X - 0.25 Y, so Z = 3 / (1 + 0.5 x + 0.25 y) along the ray (x, y,
  // 1).
  const Vec3 normal{1, -0.5, -0.25};
  const Vec3 right = (1 / square_root(1.25)) * Vec3{0.5, 1, 0};
  const Vec3 sideways = cross(normal, right);
  const Vec3 up = (1 / square_root(dot(sideways, sideways))) * sideways;
  PlaneScene scene({{{3, 0, 0}, right, up, 1e6, 1e6}}, 1);
  scene.look_from({{{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}}, {0, 0, 0}});
  for (double y = -0.4; y <= 0.4; y += 0.1) {
    for (double x = -0.6; x <= 0.6; x += 0.1)
      CHECK(scene.cast(x, y).depth_m == Approx(3 / (1 + 0.5 * x + 0.25 * y)).epsilon(1e-12));
  }
}

TEST_CASE("the wall of the standard scene is where it should be") {
  PlaneSimulator simulator;
  // The camera stands 0.1 m before the body's origin; the wall is 3.8 m from it. Forward motion brings it
  // nearer.
  CHECK(simulator.depth(0).at(0, 0) == 3700);
  const std::int64_t end_of_forward = simulator.phases()[2].end_us;
  const double x = simulator.trajectory().pose_at(end_of_forward).position[0];
  CHECK(x > 0.6);
  const recording::Grey16Picture later = simulator.depth(end_of_forward);
  CHECK(*std::max_element(later.pixels.begin(), later.pixels.end()) ==
        static_cast<int>((3.8 - x) * 1000 + 0.5));
  // Nearer things are there as well.
  const recording::Grey16Picture depth = simulator.depth(700000);
  CHECK(*std::min_element(depth.pixels.begin(), depth.pixels.end()) < 1700);
}

TEST_CASE("points move as the motion field says") {
  const PlaneSimulator simulator;
  constexpr std::int64_t kStep = Trajectory::kStepUs;
  for (const PhaseSpan& phase : simulator.phases()) {
    const std::int64_t t = (phase.begin_us + phase.end_us) / 2 / kStep * kStep;
    const CameraPose& before = simulator.trajectory().pose_at(t - kStep);
    const CameraPose& now = simulator.trajectory().pose_at(t);
    const CameraPose& after = simulator.trajectory().pose_at(t + kStep);
    for (const Ray p : {Ray{0, 0}, Ray{0.5, -0.3}, Ray{-0.4, 0.35}}) {
      const double depth = 1.7;
      const Vec3 world = now.rotation * Vec3{depth * p.x, depth * p.y, depth} + now.position;
      const Vec3 a = transpose(before.rotation) * (world - before.position);
      const Vec3 b = transpose(after.rotation) * (world - after.position);
      const double seconds = 2e-6 * kStep;
      const Ray expected = motion_field(p, depth, simulator.trajectory().twist_at(t));
      CHECK((b[0] / b[2] - a[0] / a[2]) / seconds == Approx(expected.x).margin(1e-5));
      CHECK((b[1] / b[2] - a[1] / a[2]) / seconds == Approx(expected.y).margin(1e-5));
    }
  }
}

TEST_CASE("a pixel's events follow its brightness, with exact references") {
  SensorFaults faults;
  faults.threshold = 0.2;
  faults.threshold_spread = 0;
  faults.noise_hz = 0;
  faults.readout_us = 1;
  EventSensor sensor({1, 1, 1, 1, 0, 0}, faults, 3);
  std::vector<Event> events;
  const double views[] = {0.0, 1.0, 0.0};
  for (int i = 0; i < 3; ++i) sensor.show(i * 1000, std::span<const double>(&views[i], 1), events);
  // Up by five thresholds and down again; the first reference lies within half a threshold of the first view.
  const auto up = static_cast<std::size_t>(
      std::count_if(events.begin(), events.end(), [](const Event& e) { return e.polarity == 1; }));
  CHECK((up == 4 || up == 5));
  CHECK((events.size() - up == 4 || events.size() - up == 5));
  for (std::size_t i = 1; i < up; ++i) CHECK(events[i].t_us - events[i - 1].t_us == Approx(200).margin(1.1));
  CHECK(events[up].t_us > 1000);
}

TEST_CASE("the standard recording's events are sane") {
  PlaneSimulator simulator;
  const std::int64_t until = 800000;
  const std::vector<Event> events = simulator.events(until);
  CHECK(std::is_sorted(events.begin(), events.end(),
                       [](const Event& a, const Event& b) { return a.t_us < b.t_us; }));
  std::size_t on = 0;
  for (const Event& event : events) {
    REQUIRE(event.x < 240);
    REQUIRE(event.y < 180);
    REQUIRE(event.t_us % SensorFaults{}.readout_us == 0);
    on += event.polarity;
  }
  // Standing still: noise alone, 0.02 Hz of 43,200 pixels. Moving sideways: edges everywhere.
  const double still = static_cast<double>(count_between(events, 0, 400000)) / 0.4;
  CHECK(still == Approx(0.02 * 43200).epsilon(0.02));
  const double moving = static_cast<double>(count_between(events, 600000, until)) / 0.2;
  CHECK(moving > 100e3);
  CHECK(moving < 500e3);
  const double share = static_cast<double>(on) / static_cast<double>(events.size());
  CHECK(share > 0.4);
  CHECK(share < 0.6);
}

TEST_CASE("the wall's events focus at its true depth and nowhere else") {
  PlaneSimulator simulator;
  constexpr std::int64_t kFrom = 600000;
  constexpr std::int64_t kTo = 800000;
  const std::vector<Event> events = simulator.events(kTo);
  const recording::Grey16Picture before = simulator.depth(kFrom);
  const recording::Grey16Picture after = simulator.depth(kTo);
  const std::vector<Ray> rays = pixel_rays(simulator.camera().config.camera);
  // Far enough from the rectangles that none of their events can land here.
  const auto is_wall = [&](int u, int v) {
    if (u < 14 || u >= 226 || v < 0 || v >= 180) return false;
    for (int i = u - 14; i <= u + 14; ++i) {
      if (before.at(i, v) < 3650 || after.at(i, v) < 3650) return false;
    }
    return true;
  };
  const auto sharpness = [&](double wall_m) {
    std::vector<int> votes(240 * 180, 0);
    for (const Event& event : events) {
      if (event.t_us < kFrom) continue;
      const Ray ray = rays[static_cast<std::size_t>(event.y * 240 + event.x)];
      const double x = ray.x - 1.00 * 1e-6 * static_cast<double>(kTo - event.t_us) / wall_m;
      const int u = static_cast<int>(floor_of(x * 200.0 + 121.5 + 0.5));
      const int v = static_cast<int>(floor_of(ray.y * 199.0 + 88.5 + 0.5));
      if (is_wall(u, v)) ++votes[static_cast<std::size_t>(v * 240 + u)];
    }
    double squares = 0;
    for (const int n : votes) squares += static_cast<double>(n) * n;
    return squares;
  };
  const double best = sharpness(3.7);
  for (const double wrong : {2.0, 2.5, 3.1, 4.4, 6.0, 9.0}) {
    CAPTURE(wrong);
    CHECK(sharpness(wrong) < 0.97 * best);
  }
}

#include "citysim/world.hpp"

#include <array>
#include <stdexcept>

#include "citysim/drive.hpp"
#include "citysim/fly.hpp"
#include "citysim/near_limit.hpp"

namespace egofocus::citysim {
namespace {

constexpr std::array<FamilyName, 8> kFamilies{{
    {"town1", Family::kTown1, "a suburb by day: trees, gaps, slopes"},
    {"town2_night", Family::kTown2Night, "a lit centre by night"},
    {"town3", Family::kTown3, "wide streets, high houses, much traffic, by day"},
    {"town4", Family::kTown4, "a small old town by day: narrow, cluttered"},
    {"town5_night", Family::kTown5Night, "a suburb by night, few lamps"},
    {"room", Family::kRoom, "indoors, in a hand or on a drone"},
    {"desk", Family::kDesk, "things on a table before a slider or a small arm"},
    {"corridor", Family::kCorridor, "corridors of a building, on a wheeled robot"},
}};

TownStyle town_style(Family family) {
  TownStyle s;
  switch (family) {
    case Family::kTown2Night:
      s = {.night = true,
           .block_m = 60,
           .street_half_m = 5.2,
           .pavement_m = 3.0,
           .houses = 0.95,
           .trees = 0.25,
           .parked = 0.6,
           .traffic = 0.5,
           .people = 0.6,
           .clutter = 0.5,
           .slope = 0.02,
           .lamp_m = 20};
      break;
    case Family::kTown3:
      s = {.night = false,
           .block_m = 95,
           .street_half_m = 7.0,
           .pavement_m = 4.0,
           .houses = 0.9,
           .trees = 0.5,
           .parked = 0.3,
           .traffic = 0.8,
           .people = 0.5,
           .clutter = 0.3,
           .slope = 0.01,
           .lamp_m = 35};
      break;
    case Family::kTown4:
      s = {.night = false,
           .block_m = 55,
           .street_half_m = 4.6,
           .pavement_m = 2.0,
           .houses = 0.95,
           .trees = 0.35,
           .parked = 0.5,
           .traffic = 0.4,
           .people = 0.5,
           .clutter = 0.7,
           .slope = 0.06,
           .lamp_m = 28};
      break;
    case Family::kTown5Night:
      s = {.night = true,
           .block_m = 80,
           .street_half_m = 5.6,
           .pavement_m = 2.5,
           .houses = 0.75,
           .trees = 0.6,
           .parked = 0.4,
           .traffic = 0.4,
           .people = 0.3,
           .clutter = 0.4,
           .slope = 0.05,
           .lamp_m = 38};
      break;
    default:
      s = {.night = false,
           .block_m = 75,
           .street_half_m = 5.6,
           .pavement_m = 2.5,
           .houses = 0.7,
           .trees = 0.7,
           .parked = 0.4,
           .traffic = 0.4,
           .people = 0.35,
           .clutter = 0.4,
           .slope = 0.06,
           .lamp_m = 35};
      break;
  }
  return s;
}

/// About a DAVIS346 behind a 4.5 mm lens, scaled to the picture's width.
CameraModel draw_camera(const WorldOptions& options, Random random) {
  CameraModel camera;
  Intrinsics& in = camera.intrinsics;
  in.width_px = options.width_px;
  in.height_px = options.height_px;
  in.fx_px = 0.655 * options.width_px * random.uniform(0.95, 1.12);
  in.fy_px = in.fx_px * random.uniform(0.997, 1.003);
  in.cx_px = 0.5 * (options.width_px - 1) + options.width_px * random.uniform(-0.015, 0.015);
  in.cy_px = 0.5 * (options.height_px - 1) + options.height_px * random.uniform(-0.02, 0.02);
  // k1 = -0.33 and k2 = 0.11 together can be inverted all over the picture, and so can weaker pairs.
  const double bend = random.uniform(0.3, 1.0);
  camera.distortion = Distortion::kPlumbBob;
  camera.coefficients[0] = -0.33 * bend;
  camera.coefficients[1] = 0.11 * bend * bend;
  camera.coefficients[2] = random.uniform(-5e-4, 5e-4);
  camera.coefficients[3] = random.uniform(-5e-4, 5e-4);
  return camera;
}

/// A camera that looks along the body's x, then turned: yaw to the left, pitch down, roll clockwise.
Mount mount(const Vec3& position, double yaw, double pitch, double roll) {
  const Mat3 ahead{{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}};
  const Mat3 turned = rotation({0, 0, yaw}) * rotation({0, pitch, 0}) * rotation({roll, 0, 0});
  return {turned * ahead, position};
}

/// Where a camera on wheels looks: mostly ahead and upright, but some to a side, and some askew.
struct Aim {
  double yaw, pitch, roll;
};

Aim draw_aim(double ahead_rad, double roll_rad, Random& random) {
  Aim aim{random.uniform(-ahead_rad, ahead_rad), random.uniform(-0.15, 0.28),
          random.uniform(-roll_rad, roll_rad)};
  if (random.chance(0.2)) aim.yaw = random.uniform(0.3, 1.5) * (random.chance(0.5) ? 1 : -1);
  if (random.chance(0.15)) aim.roll = random.uniform(-0.5, 0.5);
  return aim;
}

struct Motion {
  Trajectory trajectory;
  Mount mount;
  BusRobot robot;
};

Motion drive_town(const Scene& scene, bool small, double duration_s, std::uint64_t seed, Random random) {
  const Vehicle vehicle = small ? Vehicle::kDeliveryRobot : Vehicle::kCar;
  Trajectory way = drive(scene.ways, drive_style(vehicle, seed), duration_s, seed);
  const Vec3 at = small ? Vec3{random.uniform(0.1, 0.5), random.uniform(-0.1, 0.1), random.uniform(0.3, 1.1)}
                        : Vec3{random.uniform(1.0, 2.6), random.uniform(-0.4, 0.4), random.uniform(0.6, 2.5)};
  const Aim aim = draw_aim(0.12, 0.06, random);
  return {std::move(way), mount(at, aim.yaw, aim.pitch, aim.roll),
          small ? BusRobot::kDeliveryRobot : BusRobot::kCar};
}

Motion fly_room(const Scene& scene, double duration_s, std::uint64_t seed, Random random) {
  const bool drone = random.chance(0.4);
  const Flyer flyer = drone ? Flyer::kDrone : Flyer::kHand;
  const double roll = drone ? 0 : random.uniform(-0.3, 0.3);
  const double pitch = random.uniform(-0.1, 0.2);
  const double yaw = random.uniform(-0.05, 0.05);
  const Vec3 at{random.uniform(0, 0.08), random.uniform(-0.02, 0.02), random.uniform(-0.05, 0.05)};
  return {fly(scene.ways, fly_style(flyer, seed), duration_s, seed), mount(at, yaw, pitch, roll),
          drone ? BusRobot::kDrone : BusRobot::kHand};
}

Motion slide_desk(const Scene& scene, double duration_s, std::uint64_t seed, Random random) {
  const bool arm = random.chance(0.5);
  const double roll = random.uniform(-0.1, 0.1);
  const double pitch = random.uniform(-0.1, 0.1);
  const double yaw = random.uniform(-0.05, 0.05);
  const Vec3 at{random.uniform(0, 0.05), 0, random.uniform(0, 0.04)};
  return {slide(scene.ways, slide_style(arm, seed), duration_s, seed), mount(at, yaw, pitch, roll),
          BusRobot::kArm};
}

Motion drive_corridor(const Scene& scene, double duration_s, std::uint64_t seed, Random random) {
  const Vec3 at{random.uniform(0.05, 0.25), 0, random.uniform(0.2, 1.1)};
  const Aim aim = draw_aim(0.3, 0.05, random);
  return {drive(scene.ways, drive_style(Vehicle::kCorridorRobot, seed), duration_s, seed),
          mount(at, aim.yaw, aim.pitch, aim.roll), BusRobot::kDeliveryRobot};
}

}  // namespace

std::span<const FamilyName> families() {
  return kFamilies;
}

std::optional<Family> family_of(std::string_view name) {
  for (const FamilyName& known : kFamilies) {
    if (known.name == name) return known.family;
  }
  return {};
}

std::string_view name_of(Family family) {
  return kFamilies[static_cast<std::size_t>(family)].name;
}

World make_world(Family family, const WorldOptions& options, std::uint64_t seed) {
  if (options.width_px < 64 || options.width_px > 1280 || options.height_px < 64 ||
      options.height_px > 1280) {
    throw std::invalid_argument("a picture's sides must lie within 64..1280 px");
  }
  if (!(options.duration_s > 0 && options.duration_s <= 1000)) {
    throw std::invalid_argument("a recording's length must lie within (0, 1000] s");
  }
  // Towns differ although their seeds may be equal.
  seed = mix_bits(seed ^ (static_cast<std::uint64_t>(family) << 56));
  const auto library =
      options.library ? options.library : std::make_shared<const TextureLibrary>(mix_bits(seed ^ 0x7e87));
  const double duration_s = options.duration_s;
  Random random(seed, "world");
  const bool small_robot = random.chance(0.25);  // in towns
  Scene scene;
  switch (family) {
    case Family::kRoom:
      scene = make_room(library, seed);
      break;
    case Family::kDesk:
      scene = make_desk(library, seed);
      break;
    case Family::kCorridor:
      scene = make_corridor(2.1 * duration_s + 10, library, seed);
      break;
    default:
      // Cars make 15 m/s at most on the whole, with stops.
      scene = make_town(town_style(family), {(small_robot ? 3.0 : 16.0) * duration_s + 60, small_robot},
                        library, seed);
  }
  const Random mounting(seed, "mount");
  Motion motion = family == Family::kRoom       ? fly_room(scene, duration_s, seed, mounting)
                  : family == Family::kDesk     ? slide_desk(scene, duration_s, seed, mounting)
                  : family == Family::kCorridor ? drive_corridor(scene, duration_s, seed, mounting)
                                                : drive_town(scene, small_robot, duration_s, seed, mounting);
  World world{.family = family,
              .scene = std::move(scene),
              .trajectory = std::move(motion.trajectory),
              .mount = motion.mount,
              .camera = draw_camera(options, Random(seed, "camera")),
              .grid = {},
              .sensor = {},
              .robot = motion.robot};
  world.night = family == Family::kTown2Night || family == Family::kTown5Night;
  world.grid = world.camera.intrinsics;
  if (!options.clean_sensor) {
    world.sensor = draw_dvs_parameters(seed, world.night);
    world.blur = random.uniform(0.03, 0.2);
  }
  switch (family) {
    case Family::kRoom:
      world.depth_scale_m = 1.0 / 2048;
      break;
    case Family::kDesk:
      world.depth_scale_m = 1e-4;
      break;
    case Family::kCorridor:
      world.depth_scale_m = 1.0 / 1024;
      break;
    default:
      break;
  }
  // Nobody's setting is exact, and some are wrong.
  const double share = Random(seed, "near limit").log_uniform(0.005, 0.06);
  world.z_near_m = near_limit_m(world.scene, world.trajectory, world.mount, world.grid, share);
  return world;
}

}  // namespace egofocus::citysim

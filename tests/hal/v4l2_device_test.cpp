// How a V4L2 event sensor is found, understood, configured, refused and listed.
#include <string_view>

#include "hal/v4l2_bench.hpp"
#include "hal/v4l2_list.hpp"

using namespace egofocus;

namespace {

Status open(V4l2Bench& bench) {
  const Status status = bench.source->open();
  if (!status.ok()) CHECK(bench.kernel.open_files == 0);
  return status;
}

void name(char (&to)[64], const char* text) {
  std::strncpy(to, text, sizeof to - 1);
}

V4l2CameraSettings with_control(const char* control, std::int64_t value) {
  V4l2CameraSettings settings = V4l2Bench::small();
  std::strncpy(settings.controls[0].name, control, sizeof settings.controls[0].name - 1);
  settings.controls[0].value = value;
  settings.control_count = 1;
  return settings;
}

void add_biases(test::ScriptedV4l2& kernel) {
  kernel.controls["/dev/v4l-subdev2"] = {
      {.name = "bias_fo", .id = 0x00981000, .minimum = 0x2D, .maximum = 0x8C, .value = 0x50, .menu = {}},
      {.name = "bias_diff", .id = 0x00981001, .minimum = 0x34, .maximum = 0x64, .value = 0x54, .menu = {}},
      {.name = "ROI", .id = 0x00981002, .type = V4L2_CTRL_TYPE_U32, .menu = {}},
      {.name = "erc_rate",
       .id = 0x00981003,
       .type = V4L2_CTRL_TYPE_INTEGER64,
       .maximum = 200'000'000'000,
       .menu = {}},
      {.name = "temperature", .id = 0x00981004, .menu = {}, .flags = V4L2_CTRL_FLAG_READ_ONLY}};
  kernel.controls["/dev/video0"] = {{.name = "Transfer Timeout Enable",
                                     .id = 0x00981001,  // the same id as the sensor's bias_diff
                                     .type = V4L2_CTRL_TYPE_BOOLEAN,
                                     .maximum = 1,
                                     .menu = {}}};
}

std::vector<V4l2Listed> list(V4l2Bench& bench) {
  std::vector<V4l2Listed> out(8);
  out.resize(list_v4l2_cameras(out, bench.kernel.io()));
  CHECK(bench.kernel.open_files == 0);
  return out;
}

}  // namespace

TEST_CASE("V4L2: the node behind the sensor's enabled links is taken, not the first one there is") {
  V4l2Bench bench;
  REQUIRE(open(bench).ok());
  CHECK(std::string_view(bench.source->info().route.video_path) == "/dev/video0");
  CHECK(std::string_view(bench.source->info().route.sensor_path) == "/dev/v4l-subdev2");
  CHECK(std::string_view(bench.source->info().driver) == "rp1-cfe");
  bench.kernel.links = {{1, 2, true}, {2, 4, true}, {2, 3, false}, {2, 1, true}};  // and a loop
  REQUIRE(open(bench).ok());
  CHECK(std::string_view(bench.source->info().route.video_path) == "/dev/video4");
}

TEST_CASE("V4L2: links that are not set up, no sensor, and two of them are told apart") {
  V4l2Bench bench;
  bench.kernel.links[0].is_enabled = false;
  Status status = open(bench);
  CHECK(status.code() == StatusCode::kNoDevice);
  CHECK(std::string_view(status.subject()).find("links") != std::string_view::npos);

  bench.kernel.links[0].is_enabled = true;
  bench.kernel.entities[0].name = "imx219 10-0010";
  status = open(bench);
  CHECK(status.code() == StatusCode::kNoDevice);
  CHECK(status.value() == 0);

  bench.kernel.entities[0].name = "imx636 10-003c";
  bench.kernel.entities.push_back(
      {5, MEDIA_ENT_T_V4L2_SUBDEV_SENSOR, "genx320 11-003c", "/dev/v4l-subdev5", 15});
  bench.kernel.links.push_back({5, 4, true});
  status = open(bench);
  CHECK(status.code() == StatusCode::kAmbiguousDevice);
  CHECK(status.value() == 2);

  V4l2CameraSettings settings = V4l2Bench::small();
  name(settings.device, "genx320");
  V4l2CameraSource source(settings, bench.copy, bench.kernel.time.clock(), bench.kernel.io());
  REQUIRE(source.open().ok());
  CHECK(std::string_view(source.info().route.video_path) == "/dev/video4");
}

TEST_CASE("V4L2: a node by its path finds its sensor, and does without one") {
  V4l2CameraSettings settings = V4l2Bench::small();
  name(settings.device, "/dev/video0");
  V4l2Bench bench(settings);
  REQUIRE(open(bench).ok());
  CHECK(std::string_view(bench.source->info().route.sensor) == "imx636 10-003c");
  CHECK(bench.source->info().size.width_px == 1280);
  bench.kernel.entities.erase(bench.kernel.entities.begin());
  const Status status = open(bench);
  CHECK(status.code() == StatusCode::kBadDeviceSetting);  // nothing tells the geometry
  CHECK(std::string_view(status.subject()).starts_with("size"));
  settings.size = {640, 480};
  V4l2CameraSource source(settings, bench.copy, bench.kernel.time.clock(), bench.kernel.io());
  REQUIRE(source.open().ok());
  CHECK(source.info().size.height_px == 480);
  name(settings.device, "/dev/video9");
  V4l2CameraSource missing(settings, bench.copy, bench.kernel.time.clock(), bench.kernel.io());
  CHECK(missing.open().code() == StatusCode::kNoDevice);
}

TEST_CASE("V4L2: permission, another process and a node of another kind have their own status") {
  V4l2Bench bench;
  bench.kernel.open_errors["/dev/media0"] = EACCES;
  CHECK(open(bench).code() == StatusCode::kNoPermission);
  bench.kernel.open_errors = {{"/dev/video0", EACCES}};
  CHECK(open(bench).code() == StatusCode::kNoPermission);
  bench.kernel.open_errors = {{"/dev/v4l-subdev2", EACCES}};
  CHECK(open(bench).code() == StatusCode::kNoPermission);
  bench.kernel.open_errors.clear();

  bench.kernel.held_elsewhere = true;
  const Status busy = bench.source->start();
  CHECK(busy.code() == StatusCode::kDeviceBusy);
  CHECK(bench.kernel.open_files == 0);
  CHECK(bench.kernel.mapped == 0);
  bench.kernel.held_elsewhere = false;

  bench.kernel.caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  CHECK(open(bench).code() == StatusCode::kUnsupportedDevice);
  bench.kernel.caps = V4L2_CAP_VIDEO_CAPTURE;
  CHECK(open(bench).code() == StatusCode::kUnsupportedDevice);
  bench.kernel.caps = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  bench.kernel.planes = 2;
  CHECK(open(bench).code() == StatusCode::kUnsupportedDevice);
  bench.kernel.planes = 1;
  bench.kernel.fourcc = V4L2_PIX_FMT_YUYV;
  CHECK(open(bench).code() == StatusCode::kUnsupportedDevice);
}

TEST_CASE("V4L2: the fourcc tells the encoding") {
  const auto [fourcc, format] = GENERATE(table<std::uint32_t, EvtFormat>({
      {v4l2_fourcc('P', 'S', 'E', 'E'), EvtFormat::kEvt2},
      {v4l2_fourcc('P', 'S', 'E', '1'), EvtFormat::kEvt21Legacy},
      {v4l2_fourcc('P', 'S', 'E', '2'), EvtFormat::kEvt21},
      {v4l2_fourcc('P', 'S', 'E', '3'), EvtFormat::kEvt3},
  }));
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.has_format = true;
  settings.format = EvtFormat::kEvt3;
  V4l2Bench bench;
  bench.kernel.fourcc = fourcc;
  REQUIRE(open(bench).ok());
  CHECK(bench.source->info().format == format);
  CHECK_FALSE(bench.source->info().has_marker);
  V4l2CameraSource contradicted(settings, bench.copy, bench.kernel.time.clock(), bench.kernel.io());
  CHECK(contradicted.open().ok() == (format == EvtFormat::kEvt3));
}

TEST_CASE("V4L2: a disguised format is the sensor's evt_format, else the configured one, else refused") {
  V4l2Bench bench;
  bench.disguise();
  auto& encoding = bench.kernel.controls["/dev/v4l-subdev2"][0];
  encoding.menu = {"EVT2", "EVT21", "EVT3", "EVT21ME"};
  const EvtFormat formats[] = {EvtFormat::kEvt2, EvtFormat::kEvt21, EvtFormat::kEvt3,
                               EvtFormat::kEvt21Legacy};
  for (int i = 0; i < 4; ++i) {
    encoding.value = i;
    REQUIRE(open(bench).ok());
    CHECK(bench.source->info().format == formats[i]);
    CHECK(bench.source->info().has_marker);
  }
  encoding.menu[3] = "EVT9";
  CHECK(open(bench).code() == StatusCode::kBadDeviceSetting);
  bench.kernel.controls.clear();
  CHECK(open(bench).code() == StatusCode::kBadDeviceSetting);
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.has_format = true;
  settings.format = EvtFormat::kEvt21;
  V4l2CameraSource told(settings, bench.copy, bench.kernel.time.clock(), bench.kernel.io());
  REQUIRE(told.open().ok());
  CHECK(told.info().format == EvtFormat::kEvt21);
}

TEST_CASE("V4L2: the geometry is the sensor's own rectangle, else that of its name; packets are no picture") {
  V4l2Bench bench;
  bench.kernel.selections = {{V4L2_SEL_TGT_CROP_BOUNDS, {0, 0, 640, 480}}};
  REQUIRE(open(bench).ok());
  CHECK(bench.source->info().size.width_px == 640);
  bench.kernel.selections = {{V4L2_SEL_TGT_NATIVE_SIZE, {0, 0, 4096, 391}}};  // cannot be a sensor
  REQUIRE(open(bench).ok());
  CHECK(bench.source->info().size.width_px == 1280);
  CHECK(bench.source->info().size.height_px == 720);
  bench.kernel.selections.clear();
  bench.kernel.entities[0].name = "genx320 10-003c";
  REQUIRE(open(bench).ok());
  CHECK(bench.source->info().size.width_px == 320);
  CHECK(bench.source->info().size.height_px == 320);
}

TEST_CASE("V4L2: a disguised stream switches the marker on where it is off, and leaves another kind alone") {
  V4l2Bench bench;
  bench.disguise();
  auto& enable = bench.kernel.controls["/dev/v4l-subdev2"][1];
  enable.value = 0;
  REQUIRE(open(bench).ok());
  CHECK(enable.value == 3);
  enable.value = 4;
  REQUIRE(open(bench).ok());
  CHECK(enable.value == 4);
  bench.kernel.fourcc = v4l2_fourcc('P', 'S', 'E', '3');
  enable.value = 0;
  REQUIRE(open(bench).ok());
  CHECK(enable.value == 0);
  CHECK_FALSE(bench.source->info().has_marker);
}

TEST_CASE("V4L2: controls are set by name, on the sensor or the node, 64 bits wide where they are") {
  V4l2CameraSettings settings = with_control("Bias FO", 0x60);
  settings.controls[1] = {"erc_rate", 10'000'000'000};
  settings.controls[2] = {"transfer_timeout_enable", 1};
  settings.control_count = 3;
  V4l2Bench bench(settings);
  add_biases(bench.kernel);
  REQUIRE(open(bench).ok());
  CHECK(bench.kernel.value_of("/dev/v4l-subdev2", "bias_fo") == 0x60);
  CHECK(bench.kernel.value_of("/dev/v4l-subdev2", "erc_rate") == 10'000'000'000);
  CHECK(bench.kernel.value_of("/dev/video0", "Transfer Timeout Enable") == 1);
  CHECK(bench.kernel.value_of("/dev/v4l-subdev2", "bias_diff") == 0x54);
}

TEST_CASE(
    "V4L2: a control that does not exist or fit is refused before any is set, with the names that exist") {
  const auto refused = [](const char* control, std::int64_t value) {
    V4l2CameraSettings settings = with_control("bias_fo", 0x60);
    std::strncpy(settings.controls[1].name, control, sizeof settings.controls[1].name - 1);
    settings.controls[1].value = value;
    settings.control_count = 2;
    V4l2Bench bench(settings);
    add_biases(bench.kernel);
    const Status status = open(bench);
    CHECK(status.code() == StatusCode::kBadDeviceSetting);
    CHECK(bench.kernel.value_of("/dev/v4l-subdev2", "bias_fo") == 0x50);
    char line[256];
    describe_refused_control(settings, bench.source->info(), line);
    return std::string(line);
  };
  CHECK(refused("bias_foo", 1) ==
        "control 'bias_foo': there is no control of this name; there are: bias_fo bias_diff erc_rate "
        "temperature transfer_timeout_enable");
  CHECK(refused("bias_diff", 0x65) == "control 'bias_diff': the value is out of its range, 52 .. 100");
  CHECK(refused("temperature", 5) == "control 'temperature': it can only be read, 0 .. 255");
  char line[32];
  CHECK(describe_refused_control({}, {}, line) == 0);
  CHECK(line[0] == '\0');
}

TEST_CASE("V4L2: settings are checked before anything is opened; too small a copy names the bytes") {
  const auto code = [](auto change) {
    V4l2CameraSettings settings = V4l2Bench::small();
    change(settings);
    V4l2Bench bench(settings);
    const Status status = open(bench);
    CHECK(bench.kernel.opened == 0);
    return status.code();
  };
  CHECK(code([](auto& s) { s.buffers = 1; }) == StatusCode::kBadDeviceSetting);
  CHECK(code([](auto& s) { s.buffers = 33; }) == StatusCode::kBadDeviceSetting);
  CHECK(code([](auto& s) { s.frame_bytes = 4095; }) == StatusCode::kBadDeviceSetting);
  CHECK(code([](auto& s) { s.size = {7, 100}; }) == StatusCode::kBadDeviceSetting);
  CHECK(code([](auto& s) { s.silence_ms = -1; }) == StatusCode::kBadDeviceSetting);
  CHECK(code([](auto& s) { s.control_count = 33; }) == StatusCode::kBadDeviceSetting);

  V4l2Bench bench;
  V4l2CameraSource narrow(V4l2Bench::small(), std::span(bench.copy).first(100), bench.kernel.time.clock(),
                          bench.kernel.io());
  const Status status = narrow.open();
  CHECK(status.code() == StatusCode::kArenaTooSmall);
  CHECK(status.bound() == 16384);
  bench.kernel.frame_bytes = 16385;
  const Status big = open(bench);
  CHECK(big.code() == StatusCode::kBadDeviceSetting);
  CHECK(big.bound() == 16385);
}

TEST_CASE("V4L2: whatever call fails at start, nothing stays open or mapped") {
  const unsigned long request =
      GENERATE(VIDIOC_QUERYCAP, VIDIOC_G_FMT, VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF, VIDIOC_STREAMON);
  V4l2Bench bench;
  bench.kernel.errors[request] = {ENOMEM};
  CHECK_FALSE(bench.source->start().ok());
  CHECK(bench.kernel.open_files == 0);
  CHECK(bench.kernel.mapped == 0);
  bench.start();
  bench.kernel.driver_buffers = GENERATE(1u, 33u);
  CHECK(bench.source->start().code() == StatusCode::kIo);
  CHECK(bench.kernel.mapped == 0);
}

TEST_CASE("V4L2: the list says what keeps each sensor from being used") {
  V4l2Bench bench;
  bench.kernel.entities.pop_back();  // the node that nothing leads to
  bench.kernel.links.erase(bench.kernel.links.begin() + 1);
  const auto state = [&] {
    const std::vector<V4l2Listed> all = list(bench);
    REQUIRE(all.size() == 1);
    return all[0].state;
  };
  CHECK(state() == V4l2State::kFine);
  CHECK(list(bench)[0].info.format == EvtFormat::kEvt3);
  bench.kernel.held_elsewhere = true;
  CHECK(state() == V4l2State::kBusy);
  bench.kernel.held_elsewhere = false;
  bench.kernel.open_errors["/dev/video0"] = EACCES;
  CHECK(state() == V4l2State::kNoPermission);
  bench.kernel.open_errors["/dev/video0"] = EIO;
  CHECK(state() == V4l2State::kUnusable);
  bench.kernel.open_errors.clear();
  bench.kernel.fourcc = V4L2_PIX_FMT_GREY;
  CHECK(state() == V4l2State::kNoFormat);
  bench.kernel.fourcc = V4L2_PIX_FMT_YUYV;
  CHECK(state() == V4l2State::kNoFormat);
  bench.kernel.links.clear();
  CHECK(state() == V4l2State::kNotLinked);
  bench.kernel.open_errors["/dev/media0"] = EACCES;
  CHECK(state() == V4l2State::kNoPermission);
  bench.kernel.open_errors["/dev/media0"] = ENOENT;
  CHECK(list(bench).empty());
}

TEST_CASE("V4L2: the list changes nothing, and finds event nodes that no media device names") {
  V4l2Bench bench;
  bench.disguise();
  bench.kernel.controls["/dev/v4l-subdev2"][1].value = 0;
  CHECK(list(bench)[0].state == V4l2State::kFine);
  CHECK(bench.kernel.value_of("/dev/v4l-subdev2", "Enable End of Frame Marker") == 0);
  CHECK(bench.kernel.memory.empty());
  bench.kernel.fourcc = v4l2_fourcc('P', 'S', 'E', '3');
  bench.kernel.open_errors["/dev/media0"] = ENOENT;
  const std::vector<V4l2Listed> all = list(bench);
  REQUIRE(all.size() == 2);  // this kernel has two nodes, and both say PSE3
  CHECK(std::string_view(all[0].info.route.video_path) == "/dev/video0");
  CHECK(std::string_view(all[1].info.route.video_path) == "/dev/video4");
  CHECK(all[0].state == V4l2State::kNoFormat);  // the geometry must be set
}

// What devices count, in health: every name once, counters as counters, states as gauges.
#include "device_facts.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "health_text.hpp"

using namespace egofocus;
using namespace egofocus::daemon;

TEST_CASE("what devices count stands in the JSON object and in the metrics") {
  UsbCameraCounters camera;
  camera.phase = UsbCameraPhase::kStreaming;
  camera.lost = 3;
  camera.device_dropped = 41;
  SocketCanHealth bus;
  bus.link = CanLink::kUp;
  bus.kernel_dropped = 7;
  DaemonFacts facts;
  tell(camera, facts.devices);
  tell(bus, facts.devices);
  const HealthText text = health_text(facts);
  for (const char* part : {"\"camera_streaming\": 1", "\"camera_lost\": 3", "\"camera_device_dropped\": 41",
                           "\"can_link_up\": 1", "\"can_kernel_dropped\": 7"})
    CHECK_THAT(text.json, Catch::Contains(part));
  CHECK_THAT(text.metrics,
             Catch::Contains("# TYPE egofocus_camera_streaming gauge\negofocus_camera_streaming 1\n"));
  CHECK_THAT(text.metrics,
             Catch::Contains("# TYPE egofocus_camera_lost_total counter\negofocus_camera_lost_total 3\n"));
  CHECK_THAT(text.metrics, Catch::Contains("egofocus_can_kernel_dropped_total 7\n"));
}

TEST_CASE("no two facts of a camera and a bus have one name") {
  std::vector<DeviceFact> of_usb, of_v4l2;
  tell(UsbCameraCounters{}, of_usb);
  tell(V4l2CameraCounters{}, of_v4l2);
  for (std::vector<DeviceFact>* facts : {&of_usb, &of_v4l2}) {
    tell(SocketCanHealth{}, *facts);
    std::set<std::string> names;
    for (const DeviceFact& fact : *facts) CHECK(names.insert(fact.name).second);
  }
}

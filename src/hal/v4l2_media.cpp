#include "hal/v4l2_media.hpp"

#include <linux/media.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "hal/v4l2_file.hpp"
#include "hal/v4l2_text.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kMostMedia = 16;
constexpr std::size_t kMostEntities = 64;
constexpr std::size_t kMostLinks = 32;  // out of one entity

// The entities of one media device.
class Graph {
 public:
  explicit Graph(const V4l2File& media) noexcept : media_(media) {
    std::uint32_t id = 0;
    while (count_ < entities_.size()) {
      media_entity_desc& entity = entities_[count_];
      entity = {};
      entity.id = id | MEDIA_ENT_ID_FLAG_NEXT;
      if (media.ioctl(MEDIA_IOC_ENUM_ENTITIES, entity) < 0 || entity.id <= id) break;
      entity.name[sizeof entity.name - 1] = '\0';
      id = entity.id;
      ++count_;
    }
  }
  [[nodiscard]] std::span<const media_entity_desc> entities() const noexcept {
    return {entities_.data(), count_};
  }

  // The first video node that enabled links lead to, breadth first; nullptr: none.
  [[nodiscard]] const media_entity_desc* video_node_behind(const media_entity_desc& sensor) const noexcept {
    std::array<const media_entity_desc*, kMostEntities> reached{&sensor};
    std::size_t reached_count = 1;
    for (std::size_t next = 0; next < reached_count; ++next) {
      const media_entity_desc& entity = *reached[next];
      if (entity.type == MEDIA_ENT_T_DEVNODE_V4L) return &entity;
      if (entity.links > kMostLinks || entity.pads > kMostLinks) continue;
      std::array<media_link_desc, kMostLinks> links{};
      std::array<media_pad_desc, kMostLinks> pads{};
      media_links_enum query{};
      query.entity = entity.id;
      query.pads = pads.data();
      query.links = links.data();
      if (media_.ioctl(MEDIA_IOC_ENUM_LINKS, query) < 0) continue;
      for (std::size_t i = 0; i < entity.links; ++i) {
        if ((links[i].flags & MEDIA_LNK_FL_ENABLED) == 0) continue;
        const media_entity_desc* const sink = find(links[i].sink.entity);
        const auto end = reached.begin() + static_cast<std::ptrdiff_t>(reached_count);
        if (sink == nullptr || std::find(reached.begin(), end, sink) != end) continue;
        reached[reached_count++] = sink;  // each entity once: there is room
      }
    }
    return nullptr;
  }

 private:
  [[nodiscard]] const media_entity_desc* find(std::uint32_t id) const noexcept {
    for (const media_entity_desc& entity : entities()) {
      if (entity.id == id) return &entity;
    }
    return nullptr;
  }

  const V4l2File& media_;
  std::array<media_entity_desc, kMostEntities> entities_{};
  std::size_t count_ = 0;
};

}  // namespace

const char* sensor_model(const char* entity) noexcept {
  const std::string_view name = entity;
  if (name.starts_with("imx636")) return "imx636";
  if (name.starts_with("genx320")) return "genx320";
  return "";
}

void find_v4l2_routes(const V4l2Io& io, V4l2Routes& routes) noexcept {
  routes = {};
  for (std::uint32_t i = 0; i < kMostMedia; ++i) {
    char path[sizeof V4l2Route::media_path];
    V4l2Text(path).text("/dev/media").number(i);
    V4l2File media(io);
    if (const int code = media.open(path); code < 0) {
      if (code == -EACCES || code == -EPERM) ++routes.forbidden;
      continue;
    }
    const Graph graph(media);
    for (const media_entity_desc& entity : graph.entities()) {
      if (entity.type != MEDIA_ENT_T_V4L2_SUBDEV_SENSOR || sensor_model(entity.name)[0] == '\0') continue;
      if (routes.count == V4l2Routes::kMost) return;
      V4l2Route& route = routes.items[routes.count++];
      V4l2Text(route.sensor).text(entity.name);
      V4l2Text(route.media_path).text(path);
      if (io.path_of(io.self, entity.dev.major, entity.dev.minor, std::span<char>(route.sensor_path)) < 0)
        route.sensor_path[0] = '\0';
      const media_entity_desc* const node = graph.video_node_behind(entity);
      if (node == nullptr) continue;
      route.video_major = node->dev.major;
      route.video_minor = node->dev.minor;
      if (io.path_of(io.self, node->dev.major, node->dev.minor, std::span<char>(route.video_path)) < 0)
        route.video_path[0] = '\0';
    }
  }
}

}  // namespace egofocus

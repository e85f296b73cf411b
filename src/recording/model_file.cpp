#include "recording/model_file.hpp"

#include <memory>

#include "pipeline/model.hpp"
#include "recording/replay.hpp"

namespace egofocus::recording {

ModelFile::ModelFile(const std::filesystem::path& path) : file_(path) {
  const auto model = std::make_unique<Model>();
  require(read_model(file_.bytes(), *model), path.string(), ExitCode::kBadFile);
}

}  // namespace egofocus::recording

#include "host/open_writer.h"

#include <cstddef>

#include <fmt/format.h>

#include "host/interface_struct.h"
#include "host/option_values.h"
#include "host/plugin_table.h"

namespace kinora::host {

WriterHandle open_writer(const KinoraFormat& format, std::uint64_t capability, const char* content,
                         const std::filesystem::path& path, const Options& options) {
  if (!supports(format, capability))
    throw Error(ErrorCode::kUsage, fmt::format("the format {} does not write {}", format.name, content));
  check_options(format, options);
  const std::vector<KinoraOptionValue> values = option_values(options);
  auto message = make_struct<KinoraMessage>();
  KinoraWriter* writer = nullptr;
  const KinoraStatus status = format.open_writer(path.c_str(), values.data(), values.size(), &writer, &message);
  if (status != KINORA_OK) throw error_of(status, message, path.string());
  if (writer == nullptr)
    throw Error(ErrorCode::kFailure,
                fmt::format("the plugin of the format {} opened {} and gave no writer; get a corrected build of it",
                            format.name, path.string()));
  return {writer, format.writer_abandon};
}

void describe_output(const KinoraFormat& format, const WriterHandle& writer, const Facts& facts) {
  if (facts.empty() || format.struct_size < offsetof(KinoraFormat, reader_sound) || format.writer_facts == nullptr)
    return;
  std::vector<KinoraOptionValue> given;
  for (const auto& [name, value] : facts) given.push_back({name.c_str(), value.c_str()});
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format.writer_facts(writer.get(), given.data(), given.size(), &message);
  if (status != KINORA_OK) throw error_of(status, message, format.name);
}

void finish_writer(const KinoraFormat& format, WriterHandle& writer) {
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format.writer_finish(writer.release(), &message);
  if (status != KINORA_OK) throw error_of(status, message, format.name);
}

} // namespace kinora::host

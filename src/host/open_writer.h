// What all writers share: opening, finishing, abandoning.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/options.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// A plugin's writer; abandoned when it goes out of scope unfinished.
using WriterHandle = std::unique_ptr<KinoraWriter, void (*)(KinoraWriter*)>;

/// Throws what the plugin reports, and Error(kUsage) for options that the format does not declare or a format without
/// the capability, of which `content` is the name ("pictures").
WriterHandle open_writer(const KinoraFormat& format, std::uint64_t capability, const char* content,
                         const std::filesystem::path& path, const Options& options);

/// What a file may say of how it was made: names and values.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// Tells a writer that was just opened, if its format has a place for it. Throws what the plugin reports.
void describe_output(const KinoraFormat& format, const WriterHandle& writer, const Facts& facts);

/// Completes the output and frees the writer. Throws what the plugin reports.
void finish_writer(const KinoraFormat& format, WriterHandle& writer);

} // namespace kinora::host

#include "host/volume_writer.h"

#include <iterator>

#include "host/interface_struct.h"

namespace kinora::host {

void write_volume(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                  const Volume& volume, const Facts& facts) {
  WriterHandle writer = open_writer(format, KINORA_WRITES_VOLUMES, "volumes", path, options);
  describe_output(format, writer, facts);
  const KinoraVolumeChannel channels[] = {
      {"density", 1, volume.density.data()},
      {"color", 3, numbers_of(volume.color)},
  };
  auto given = make_struct<KinoraVolume>();
  given.name = volume.name.c_str();
  given.frame = volume.frame;
  given.time = volume.time;
  for (int i = 0; i < 16; ++i) given.voxel_to_world[i] = volume.voxel_to_world(i / 4, i % 4);
  given.voxel_count = volume.voxels.size();
  given.voxels = numbers_of(volume.voxels);
  given.channels = channels;
  given.channel_count = std::size(channels);
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format.writer_volume(writer.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format.name);
  finish_writer(format, writer);
}

} // namespace kinora::host

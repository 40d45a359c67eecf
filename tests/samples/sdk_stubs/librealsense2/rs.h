/* Of librealsense 2 what samples/camera_plugin uses, so that it is compiled where the SDK is not installed. */
#ifndef STUB_RS_H
#define STUB_RS_H

#define RS2_API_VERSION 25000

typedef struct rs2_context rs2_context;
typedef struct rs2_pipeline rs2_pipeline;
typedef struct rs2_config rs2_config;
typedef struct rs2_pipeline_profile rs2_pipeline_profile;
typedef struct rs2_processing_block rs2_processing_block;
typedef struct rs2_frame_queue rs2_frame_queue;
typedef struct rs2_frame rs2_frame;
typedef struct rs2_stream_profile rs2_stream_profile;
typedef struct rs2_error rs2_error;
typedef double rs2_time_t;
typedef enum { RS2_STREAM_ANY, RS2_STREAM_DEPTH, RS2_STREAM_COLOR } rs2_stream;
typedef enum { RS2_FORMAT_ANY, RS2_FORMAT_Z16, RS2_FORMAT_RGB8 = 5 } rs2_format;
typedef enum { RS2_DISTORTION_NONE, RS2_DISTORTION_BROWN_CONRADY = 4 } rs2_distortion;
typedef struct rs2_intrinsics {
  int width, height;
  float ppx, ppy, fx, fy;
  rs2_distortion model;
  float coeffs[5];
} rs2_intrinsics;

const char* rs2_get_error_message(const rs2_error*);
void rs2_free_error(rs2_error*);
rs2_context* rs2_create_context(int, rs2_error**);
void rs2_delete_context(rs2_context*);
rs2_processing_block* rs2_create_align(rs2_stream, rs2_error**);
void rs2_delete_processing_block(rs2_processing_block*);
rs2_frame_queue* rs2_create_frame_queue(int, rs2_error**);
void rs2_delete_frame_queue(rs2_frame_queue*);
void rs2_start_processing_queue(rs2_processing_block*, rs2_frame_queue*, rs2_error**);
void rs2_process_frame(rs2_processing_block*, rs2_frame*, rs2_error**);
int rs2_try_wait_for_frame(rs2_frame_queue*, unsigned int, rs2_frame**, rs2_error**);
int rs2_embedded_frames_count(rs2_frame*, rs2_error**);
rs2_frame* rs2_extract_frame(rs2_frame*, int, rs2_error**);
void rs2_release_frame(rs2_frame*);
const rs2_stream_profile* rs2_get_frame_stream_profile(const rs2_frame*, rs2_error**);
void rs2_get_stream_profile_data(const rs2_stream_profile*, rs2_stream*, rs2_format*, int*, int*, int*, rs2_error**);
void rs2_get_video_stream_intrinsics(const rs2_stream_profile*, rs2_intrinsics*, rs2_error**);
const void* rs2_get_frame_data(const rs2_frame*, rs2_error**);
rs2_time_t rs2_get_frame_timestamp(const rs2_frame*, rs2_error**);
float rs2_depth_frame_get_units(const rs2_frame*, rs2_error**);

#endif

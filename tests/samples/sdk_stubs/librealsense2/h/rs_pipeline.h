/* As ../rs.h. */
#ifndef STUB_RS_PIPELINE_H
#define STUB_RS_PIPELINE_H

#include "../rs.h"

rs2_pipeline* rs2_create_pipeline(rs2_context*, rs2_error**);
void rs2_delete_pipeline(rs2_pipeline*);
rs2_config* rs2_create_config(rs2_error**);
void rs2_delete_config(rs2_config*);
void rs2_config_enable_device(rs2_config*, const char*, rs2_error**);
void rs2_config_enable_stream(rs2_config*, rs2_stream, int, int, int, rs2_format, int, rs2_error**);
rs2_pipeline_profile* rs2_pipeline_start_with_config(rs2_pipeline*, rs2_config*, rs2_error**);
void rs2_delete_pipeline_profile(rs2_pipeline_profile*);
void rs2_pipeline_stop(rs2_pipeline*, rs2_error**);
rs2_frame* rs2_pipeline_wait_for_frames(rs2_pipeline*, unsigned int, rs2_error**);

#endif

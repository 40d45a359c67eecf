// Larger tables for a field that has already learnt something.
#pragma once

#include "fields/model/field.h"

namespace kinora::fields {

/// `config` with twice the entries in every level that is not stored densely.
FieldConfig with_doubled_tables(const FieldConfig& config);
/// Whether that changes anything, and keeps the limits of a field.
bool can_double_tables(const FieldConfig& config);

/// The rows of a table (or of its moments) of `config` for its doubled tables: each vertex finds what it found before.
LargeBuffer<float> with_doubled_rows(const FieldConfig& config, const LargeBuffer<float>& rows);

/// The field with doubled tables. It draws what the field draws.
Field with_doubled_tables(const Field& field);

} // namespace kinora::fields

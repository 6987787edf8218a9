#pragma once
// What the lights of a group bring to eye points and to the picture without shadows.
#include "viscache/render/eye_paths.h"
#include "viscache/render/shared_lights.h"

namespace viscache {

/// Contributions of the columns to the light that an eye point reflects: contribution_row or, for a surface
/// with a lobe, contribution_row_glossy of the set bits of `wanted`. Returns the mean of the positive ones.
float reflected_row(const SharedLights& lights, const EyeTile& eyes, size_t eye, ColumnRange range,
                    const Word* wanted, std::vector<float>& row);

/// From such a contribution to what it adds to the pixel of the eye point, as a mean of channels.
float to_pixel(const EyeTile& eyes, size_t eye);

/// Sets `mean_light` of each group: the mean over the picture of what its lights would bring to a pixel
/// without shadows, from a small picture of the same view.
void set_mean_light(std::span<SharedLights> groups, const EyePathTracer& tracer, Counters& counters,
                    const Control& control);

}  // namespace viscache

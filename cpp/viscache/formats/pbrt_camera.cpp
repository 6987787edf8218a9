// pbrt text: camera and film.
#include "viscache/formats/pbrt_reader.h"

namespace viscache::loading {

void PbrtReader::camera(const Names& names, const PbrtParams& params, const std::string& where) {
    const std::string& type = names[0];
    const auto to_world = inverse_of(now_.ctm);
    if (!to_world) fail(where, "the camera's transform has no inverse");
    // Lights may be placed relative to the camera by this name.
    coordinate_systems_["camera"] = *to_world;
    const bool parallel = type == "orthographic";
    if (type != "perspective" && !parallel) {
        params.ignore_all();
        return loading_.warn(where, "camera '" + type + "' is not modelled; skipped");
    }
    params.ignore({"focaldistance"});  // of no effect without a lens
    if (params.number("lensradius", 0) > 0)
        loading_.warn(where, "depth of field is not modelled; all distances are sharp");
    PendingCamera pending;
    pending.where = where;
    pending.exposure = params.number("shutterclose", 1) - params.number("shutteropen", 0);
    if (const PbrtParam* window = params.find("screenwindow")) {
        const auto& v = window->numbers;
        if (v.size() != 4 || !(v[1] > v[0] && v[3] > v[2]))
            fail(window->where, "a screen window must be four numbers: x from and to, y from and to");
        pending.window = {v[0], v[1], v[2], v[3]};
    }
    if (params.has("frameaspectratio")) pending.aspect = params.number("frameaspectratio", 1);
    Camera& c = pending.camera;
    c.origin = to_world->point({0, 0, 0});
    c.right = normalize(to_world->vector({1, 0, 0}));
    c.up = normalize(to_world->vector({0, 1, 0}));
    c.forward = normalize(to_world->vector({0, 0, 1}));
    // One unit of the screen: of the plane at distance 1, or in the scene
    if (parallel) {
        // A scale in the transform enlarges what a parallel camera sees, and leaves a perspective one as it
        // is.
        pending.unit = double(length(to_world->vector({0, 1, 0})));
        c.view_height = 1;
    } else {
        const double fov =
            params.number("fov", params.has("halffov") ? 2 * params.number("halffov", 45) : 90);
        if (!(fov > 0 && fov < 180)) fail(where, "the field of view must be in (0, 180) degrees");
        pending.unit = std::tan(fov * (3.14159265358979323846 / 360));
    }
    camera_ = pending;
}

void PbrtReader::film(const Names& names, const PbrtParams& params, const std::string& where) {
    const std::string& type = names[0];
    // pbrt-v3 knows one film, "image". Files of v4 have no WorldEnd.
    is_v4_ = is_v4_ || type == "rgb" || type == "gbuffer" || type == "spectral";
    if (const std::string sensor = params.string("sensor", "cie1931"); sensor != "cie1931")
        loading_.warn(where, "the sensor '" + sensor + "' is not modelled; colours are those of the scene");
    // The file of the picture, the size of a film behind lenses, and limits that keep noise down
    params.ignore({"filename", "savefp16", "diagonal", "maxcomponentvalue", "maxsampleluminance",
                   "coordinatesystem", "nbuckets", "lambdamin", "lambdamax"});
    params.ignore_at(100, {"iso"});
    params.ignore_at(1, {"scale"});
    params.ignore_at(0, {"whitebalance"});
    film_width_ = params.integer("xresolution", film_width_);
    film_height_ = params.integer("yresolution", film_height_);
    if (film_width_ < 1 || film_height_ < 1) fail(where, "the film's resolution must be >= 1");
    if (const PbrtParam* crop = params.find("cropwindow")) {
        const auto& v = crop->numbers;
        if (v.size() != 4)
            fail(crop->where, "a crop window must be four numbers: x from and to, y from and to");
        // As pbrt rounds: the pixels whose index is at least the ceiling of the fraction.
        const auto edge = [](double x, int size) { return int(std::ceil(std::clamp(x, 0.0, 1.0) * size)); };
        crop_ = {edge(std::min(v[0], v[1]), film_width_), edge(std::max(v[0], v[1]), film_width_),
                 edge(std::min(v[2], v[3]), film_height_), edge(std::max(v[2], v[3]), film_height_)};
    }
    if (const PbrtParam* bounds = params.find("pixelbounds")) {
        const auto& v = bounds->numbers;
        if (v.size() != 4)
            fail(bounds->where, "pixel bounds must be four numbers: x from and to, y from and to");
        const auto edge = [](double x, int size) { return int(std::clamp(x, 0.0, double(size))); };
        crop_ = {edge(v[0], film_width_), edge(v[1], film_width_), edge(v[2], film_height_),
                 edge(v[3], film_height_)};
    }
    if (crop_ && ((*crop_)[1] <= (*crop_)[0] || (*crop_)[3] <= (*crop_)[2]))
        fail(where, "the crop has no pixels");
}

void PbrtReader::finish_camera() {
    if (!camera_) return;
    // pbrt-v3 takes the shutter for motion alone
    if (is_v4_ && std::abs(camera_->exposure - 1) > 1e-6)
        loading_.warn(camera_->where, "exposure is not modelled; the picture has the radiance of the scene");
    Camera c = camera_->camera;
    c.width = film_width_;
    c.height = film_height_;
    // By default, the shorter side of the film spans [-1, 1]
    const double film = double(film_width_) / film_height_, aspect = camera_->aspect.value_or(film);
    const std::array<double, 4> usual = aspect > 1 ? std::array<double, 4>{-aspect, aspect, -1, 1}
                                                   : std::array<double, 4>{-1, 1, -1 / aspect, 1 / aspect};
    const auto [x0, x1, y0, y1] = camera_->window.value_or(usual);
    if (std::abs((x1 - x0) / (y1 - y0) / film - 1) > 1e-3)
        loading_.warn(camera_->where,
                      "pixels that are not square are not modelled; the film's shape is used");
    // Both sides of the film give the same camera; the shorter one keeps it when the size is changed
    c.fov_is_horizontal = film_width_ < film_height_;
    const double half = (c.fov_is_horizontal ? x1 - x0 : y1 - y0) / 2 * camera_->unit;
    if (c.is_orthographic()) {
        const Vec3 centre = c.right * float((x0 + x1) / 2) + c.up * float((y0 + y1) / 2);
        c.view_height = float(2 * half);
        c.origin = c.origin + centre * float(camera_->unit);
    } else {
        c.fov_y_rad = float(2 * std::atan(half));
        // A window beside the axis, as of a shift lens: in widths and heights of the picture.
        c.shift_x = float((x0 + x1) / 2 / (x1 - x0));
        c.shift_y = float((y0 + y1) / 2 / (y1 - y0));
    }
    if (crop_) {
        const auto [left, right, top, bottom] = *crop_;
        crop_camera(c, left, top, right - left, bottom - top);
    }
    loading_.scene.cameras.push_back(c);
}

}  // namespace viscache::loading

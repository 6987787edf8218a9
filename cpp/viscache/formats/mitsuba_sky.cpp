// Mitsuba XML: clear skies and their sun (`sunsky` of 3.x; `sky`, `sun` and `sunsky` of 0.5 and 0.6).
#include "viscache/formats/mitsuba_reader.h"
#include "viscache/scene/sky.h"

namespace viscache::loading {

namespace {

constexpr int kWidth = 1024;  // of the sky's image

/// From the frame of the sky's map (y up) to the emitter's frame with z up.
Affine z_up() {
    Affine t;
    t.m = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
    return t;
}

}  // namespace

/// Direction to the sun in the emitter's frame.
Vec3 MitsubaReader::sky_to_sun(Node node, const Affine& to_world, bool z_is_up) {
    if (const auto given = vector(node, "sun_direction")) {
        const auto to_local = inverse_of(to_world);
        const Vec3 local = to_local ? normalize(to_local->vector(*given)) : Vec3{};
        if (length2(local) == 0) fail_at(node, "the sun needs a direction and a transform with an inverse");
        return local;
    }
    SunTime time;
    time.year = integer(node, "year", time.year);
    time.month = integer(node, "month", time.month);
    time.day = integer(node, "day", time.day);
    time.hour =
        number(node, "hour", time.hour) + number(node, "minute", 0) / 60 + number(node, "second", 0) / 3600;
    time.timezone = number(node, "timezone", time.timezone);
    time.latitude = number(node, "latitude", time.latitude);
    time.longitude = number(node, "longitude", time.longitude);
    const Vec3 at = sun_direction(time);  // east, up, north
    return z_is_up ? Vec3{-at.z, -at.x, at.y} : Vec3{at.x, at.y, -at.z};
}

void MitsubaReader::sky(Node node, const std::string& type) try {
    const bool z_is_up = version_major_ >= 3;
    Affine to_world = transform(node);
    Vec3 to_sun = sky_to_sun(node, to_world, z_is_up);
    if (z_is_up) {
        to_world = to_world * z_up();
        to_sun = {to_sun.x, to_sun.z, -to_sun.y};
    }
    SkySettings settings;
    settings.to_sun = to_sun;
    settings.turbidity = float(number(node, "turbidity", 3));
    const float albedo = z_is_up ? 0.3f : 0.2f, scale = float(number(node, "scale", 1));
    settings.albedo = color(node, "albedo", {albedo, albedo, albedo});
    settings.stretch = float(number(node, "stretch", 1));
    settings.extend = boolean(node, "extend", false);
    const ClearSky model(settings);
    if (to_sun.y < 0) warn_at(node, "the sun is below the horizon; '" + type + "' gives no light");
    if (type != "sky") {
        const float sun = type == "sun" ? scale : float(number(node, "sun_scale", double(scale)));
        const Rgb irradiance = model.sun_irradiance() * sun;
        if (!z_is_up && max_component(irradiance) > 0)
            warn_at(node, "the sun of Mitsuba 0.6 is not modelled; that of Hosek and Wilkie is used");
        // The first stands in files of 0.x: how large the sun is, at the same irradiance
        for (const auto& [name, usual] :
             {std::pair{"sun_radius_scale", 1.0}, std::pair{"sun_aperture", 0.5358}})
            if (number(node, name, usual) > usual && max_component(irradiance) > 0)
                warn_at(property(node, name), "the sun has no disk, its shadows are sharp");
        if (max_component(irradiance) > 0)
            loading_.scene.directional_lights.push_back(
                {normalize(to_world.vector(model.to_sun())), irradiance});
    }
    if (to_sun.y < 0) use_rest(node);
    if (type == "sun" || to_sun.y < 0) return;
    Environment env;
    const float factor = type == "sky" ? scale : float(number(node, "sky_scale", double(scale)));
    if (!(factor > 0)) return;
    env.scale = {factor, factor, factor};
    env.to_world = to_world;
    loading_.scene.images.push_back(model.image(kWidth));
    loading_.scene.images.back().where = where(node);
    env.image = int(loading_.scene.images.size()) - 1;
    loading_.set_environment(env, where(node));
} catch (const SceneError& error) {
    const std::string what = error.what();
    if (what.starts_with(where(node))) throw;
    fail_at(node, what);
}

}  // namespace viscache::loading

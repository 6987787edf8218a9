#pragma once
// The clear sky and its sun after Hosek and Wilkie (2012, 2013), in linear RGB and W/(m²·sr·nm), as Mitsuba
// 3's `sunsky`. The map's frame of `Environment` is used: y points up.
#include "viscache/scene/description.h"

namespace viscache {

struct SkySettings {
    Vec3 to_sun{0, 1, 0};       ///< unit
    float turbidity = 3;        ///< haze, in [1, 10]; 3: a clear day of the temperate zone
    Rgb albedo{.3f, .3f, .3f};  ///< of the ground, in [0, 1]
    float stretch = 1;          ///< angles from the zenith are divided by this, in [1, 2]
    bool extend = false;        ///< the horizon's radiance also below the horizon, which is black otherwise
};

/// The sky of one position of the sun. Black if the sun is below the horizon.
class ClearSky {
public:
    /// Throws SceneError for settings out of range.
    explicit ClearSky(const SkySettings& settings);

    /// Radiance from a unit direction.
    Rgb radiance(Vec3 direction) const;
    /// Irradiance of the sun on a surface that faces it.
    Rgb sun_irradiance() const;
    /// Unit direction to the sun, stretched as the sky.
    Vec3 to_sun() const;
    /// Lat-long image of the sky without the sun, `width` × `width`/2. A pixel is the mean of four points.
    Image image(int width) const;

private:
    /// What all directions of one zenith angle share.
    struct Ring {
        double cos_zenith, sin_zenith;  ///< in the sky before it was stretched
        double factor[3], summand[3];   ///< per channel
        bool is_black = false;
    };
    Ring ring(double zenith) const;
    Rgb radiance(const Ring& ring, double cos_sun) const;

    SkySettings settings_;
    double elevation_;                     ///< of the sun, rad
    double coefficients_[3][9], mean_[3];  ///< per channel
};

/// Place and local time of an observer.
struct SunTime {
    int year = 2010, month = 7, day = 10;
    double hour = 15;                                 ///< local, with fractions
    double timezone = 9;                              ///< hours east of Greenwich
    double latitude = 35.6894, longitude = 139.6917;  ///< degrees north and east
};

/// Unit direction to the sun: x east, y up, z north. Accurate to 0.5 minutes of arc for 1999–2015 (the PSA
/// algorithm, Blanco-Muriel et al. 2001). Throws SceneError for a date that does not exist.
Vec3 sun_direction(const SunTime& time);

}  // namespace viscache

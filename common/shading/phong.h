// Phong's model as every stage uses it: ambient, diffuse and specular parts of a light's intensity.
#pragma once

namespace lodestream::shading {

struct Phong {
    double ambient = 0.25;
    double diffuse = 0.75;
    double specular = 0.25;
    double shininess = 16.0;
};

}  // namespace lodestream::shading

// How the layers divide the image by depth; the includer defines SLICES_BINDING.
layout(std430, binding = SLICES_BINDING) buffer Slices {
    uint extremes[2];  // of the depths from the camera: the greatest, the greatest complement
    uint outside;      // samples that the light shines on and that their own layer does not hold
    float splits[9];   // distances along the view direction where layers begin, and the end of the last
};

// How the layers divide the image, by depth or by the faces of the view frustum; the includer defines SLICES_BINDING.
layout(std430, binding = SLICES_BINDING) buffer Slices {
    uint extremes[2];  // of the depths from the camera: the greatest, the greatest complement
    uint outside;      // samples that the light shines on and that their own layer does not hold
    float splits[9];   // distances along the view direction where layers begin, and the end of the last
    vec4 exits[5];     // how far the light's line through a sample is from leaving by a face: dot(xyz, position from the eye) + w, by the near face, the first, w * distance to it; that w is 0 where layers are slices of depth
};

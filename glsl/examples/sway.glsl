// How the wind bends a caster, mesh space: the host's passes and the casters that it draws must agree.
vec3 sway(vec3 position, float wind) { return position + vec3(wind * position.y * position.y, 0.0, 0.0); }

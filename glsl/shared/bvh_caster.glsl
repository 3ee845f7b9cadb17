// Which caster a slot holds. Needs `firsts`, `instances`, `meshes` and INSTANCE_COUNT.

// The instance whose clusters include this slot, and the cluster; false for a slot that none has.
bool slot_caster(uint slot, out uint index, out uint cluster) {
    index = 0u;
    cluster = 0u;
    if (slot >= firsts[INSTANCE_COUNT]) {
        return false;
    }
    uint end = INSTANCE_COUNT;
    while (end - index > 1u) {
        uint middle = (index + end) / 2u;
        if (firsts[middle] <= slot) {
            index = middle;
        } else {
            end = middle;
        }
    }
    cluster = meshes[instances[index].mesh].first_cluster + slot - firsts[index];
    return true;
}

// Bounds of a placed cluster relative to the scene's origin.
void placed_bounds(Instance instance, Cluster cluster, out vec3 center, out vec3 extent) {
    vec4 c = vec4(cluster.center[0], cluster.center[1], cluster.center[2], 1.0);
    vec3 e = vec3(cluster.extent[0], cluster.extent[1], cluster.extent[2]);
    for (int i = 0; i < 3; i++) {
        center[i] = dot(instance.rows[i], c);
        extent[i] = dot(abs(instance.rows[i].xyz), e);
    }
}

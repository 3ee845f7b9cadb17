// The cluster of a thread: RUN threads share an item. Needs `items`, `instances`, `meshes` and `item_count()`.

// Whether there is a cluster for this thread.
bool item_cluster(out uint instance, out uint cluster) {
    uint thread = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
    if (thread / RUN >= min(item_count(), uint(items.length()))) {
        return false;
    }
    Item item = items[thread / RUN];
    MeshBounds mesh = meshes[instances[item.instance].mesh];
    instance = item.instance;
    cluster = item.first_cluster + thread % RUN;
    return cluster < mesh.first_cluster + mesh.cluster_count;
}

// Tiles of a map with many layers: each layer holds one, at the place in the light's plane that its fit says.
const uint NO_TILE = 0xffffffffu;
const uint KEPT_TILE = 0xfffffffeu;  // a tile of a pass before served the pixel, and the method keeps what that gave

// A run of clusters of an instance that may touch a tile.
struct TileItem {
    uint tile;
    uint instance;
    uint first_cluster;
};

// What a vertex shader draws: an instance into a tile.
struct TilePair {
    uint tile;
    uint instance;
};

// What was found for the tiles that are drawn.
struct TileCounts {
    uint groups[4];  // workgroups of tile_items: runs of instances, tiles, 1; then nothing
    uint items;      // asked for
    uint opaque;     // draws, as many as there is room for
    uint masked;     // the same for what is alpha tested
    uint dropped;    // items and draws there was no room for, since the frame began
};

// What a frame of an adaptive shadow map of many iterations did.
struct AsmGpuCounts {
    uint resident;     // pages
    uint iterations;   // that made pages
    uint requested;    // distinct pages asked for, over all iterations
    uint outstanding;  // distinct pages asked for at last that were not made
    uint cells;        // nodes of the tree that are taken
    uint asking;       // 1 where samples are asked in the next iteration
};

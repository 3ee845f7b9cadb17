// What a frame of an adaptive shadow map did.
struct AsmCounts {
    uint resident;   // pages
    uint made;       // in this frame
    uint evicted;    // pages that were not in use and lost their tiles
    uint displaced;  // pages in use that lost them to others worth more
    uint waiting;    // 1 where more pages were wanted than a frame makes
    uint stale;      // pages drawn again as casters changed
};

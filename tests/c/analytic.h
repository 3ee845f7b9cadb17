// A plane and a box: what a camera sees of them, and which of it the sun reaches.
#pragma once
#include "check.h"
#include "umbrage.h"

#include <math.h>

enum { WIDTH = 320, HEIGHT = 240, PIXELS = WIDTH * HEIGHT };

// The scene, relative to its origin; the plane is y = 0.
static const double ORIGIN[3] = {1000.0, -20.0, 500.0};
static const double PLANE_REACH = 8.0;
static const double BOX[2][3] = {{-1.0, 0.75, -1.5}, {1.5, 2.5, 1.0}};

// The camera: reversed depth to infinity, off centre.
static const double EYE[3] = {4.0, 4.0, 5.5};
static const double NEAR_PLANE = 0.1, FOCAL = 1.5, SHIFT_X = 0.1, SHIFT_Y = -0.05;

typedef struct { double t; int surface; double normal[3], place[3]; } Hit;

// Where a ray enters the box; t is negative where it does not.
static Hit hit_box(const double from[3], const double along[3]) {
    Hit hit = {-1.0, 0, {0}, {0}};
    double enter = -1e30, leave = 1e30;
    int axis = 0;
    for (int i = 0; i < 3; i++) {
        double a = (BOX[0][i] - from[i]) / along[i], b = (BOX[1][i] - from[i]) / along[i];
        if (fmin(a, b) > enter) enter = fmin(a, b), axis = i;
        leave = fmin(leave, fmax(a, b));
    }
    if (enter > leave || leave < 0.0) return hit;
    double sign = along[axis] > 0.0 ? -1.0 : 1.0;
    hit.t = enter;
    hit.surface = 2 + 2 * axis + (sign > 0.0);
    hit.normal[axis] = sign;
    return hit;
}

// The nearest surface; 0 for none, 1 for the plane.
static Hit hit_scene(const double from[3], const double along[3]) {
    Hit hit = hit_box(from, along);
    double t = -from[1] / along[1], x = from[0] + t * along[0], z = from[2] + t * along[2];
    if (t > 0.0 && fabs(x) < PLANE_REACH && fabs(z) < PLANE_REACH && (hit.t < 0.0 || t < hit.t)) {
        Hit plane = {t, 1, {0.0, 1.0, 0.0}, {0}};
        return plane;
    }
    return hit;
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalize(double v[3]) {
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) v[i] /= length;
}

static UmbrageFrameInput camera(void) {
    UmbrageFrameInput input;
    memset(&input, 0, sizeof input);
    const double up[3] = {0.0, 1.0, 0.0};
    double (*rows)[3] = input.view_from_world;
    for (int i = 0; i < 3; i++) rows[2][i] = EYE[i] - (i == 1 ? 0.75 : 0.0);
    normalize(rows[2]);
    cross(up, rows[2], rows[0]);
    normalize(rows[0]);
    cross(rows[2], rows[0], rows[1]);
    input.clip_from_view[0][0] = FOCAL * HEIGHT / WIDTH;
    input.clip_from_view[0][2] = SHIFT_X;
    input.clip_from_view[1][1] = -FOCAL;
    input.clip_from_view[1][2] = SHIFT_Y;
    input.clip_from_view[2][3] = NEAR_PLANE;
    input.clip_from_view[3][2] = -1.0;
    for (int i = 0; i < 3; i++) {
        input.origin[i] = ORIGIN[i];
        input.eye[i] = ORIGIN[i] + EYE[i];
    }
    return input;
}

// What each pixel sees; t is the distance along the view direction.
static void look(const UmbrageFrameInput *input, Hit *hits) {
    for (int p = 0; p < PIXELS; p++) {
        double x = 2.0 * (p % WIDTH + 0.5) / WIDTH - 1.0, y = 2.0 * (p / WIDTH + 0.5) / HEIGHT - 1.0, along[3];
        double view[3] = {(x + SHIFT_X) / input->clip_from_view[0][0], (y + SHIFT_Y) / -FOCAL, -1.0};
        for (int i = 0; i < 3; i++) {
            along[i] = 0.0;
            for (int j = 0; j < 3; j++) along[i] += input->view_from_world[j][i] * view[j];
        }
        hits[p] = hit_scene(EYE, along);
        for (int i = 0; i < 3; i++) hits[p].place[i] = EYE[i] + hits[p].t * along[i];
    }
}

// Whether the sun reaches what a pixel sees; nothing shadows the box but itself.
static int lit(const Hit *hit, const double sun[3]) {
    const double against[3] = {-sun[0], -sun[1], -sun[2]};
    if (hit->surface == 0) return 1;
    if (hit->surface == 1) return hit_box(hit->place, against).t < 0.0;
    return dot(hit->normal, against) > 0.0;
}

// Differences between the mask and the analytic answer, more than two pixels away from any edge.
static void compare(const char *what, const Hit *hits, const double sun[3], const float *mask) {
    int checked[2] = {0, 0}, wrong = 0;
    for (int y = 2; y < HEIGHT - 2; y++) {
        for (int x = 2; x < WIDTH - 2; x++) {
            const Hit *hit = &hits[y * WIDTH + x];
            int want = lit(hit, sun), same = hit->surface != 0;
            for (int i = 0; i < 25 && same; i++) {
                const Hit *other = &hits[(y + i / 5 - 2) * WIDTH + x + i % 5 - 2];
                same = other->surface == hit->surface && lit(other, sun) == want;
            }
            if (!same) continue;
            checked[want]++;
            wrong += mask[y * WIDTH + x] != (float)want;
        }
    }
    printf("%s: %d lit and %d shadowed pixels checked, %d wrong\n", what, checked[1], checked[0], wrong);
    if (wrong || checked[0] < 2000 || checked[1] < 10000) fail(what, "not the analytic mask");
}

/* SPDX-License-Identifier: MIT
 *
 * The few matrix operations of the node hierarchy, in double: chains of transforms as deep as files
 * have them, rounded to float once at the end.
 */
#include "scene/animations.h"

#include <math.h>
#include <string.h>

void scene_compose(const scene_pose *pose, double m[16]) {
    const double *q = pose->rotation, *s = pose->scale, *t = pose->translation;
    double x = q[0], y = q[1], z = q[2], w = q[3];
    double rotation[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
        2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y),
    };
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++)
            m[column * 4 + row] = rotation[column * 3 + row] * s[column];
        m[column * 4 + 3] = 0.0;
        m[12 + column] = t[column];
    }
    m[15] = 1.0;
}

void scene_multiply(const double a[16], const double b[16], double out[16]) {
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int i = 0; i < 4; i++)
                sum += a[i * 4 + row] * b[column * 4 + i];
            out[column * 4 + row] = sum;
        }
}

void scene_normalize_rotation(double q[4]) {
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (length > 0.0 && isfinite(length)) {
        for (int i = 0; i < 4; i++)
            q[i] /= length;
    } else {
        memcpy(q, (const double[4]){0.0, 0.0, 0.0, 1.0}, 4 * sizeof *q);
    }
}

int scene_narrow(const double from[16], float to[16]) {
    int finite = 1;
    for (int i = 0; i < 16; i++) {
        to[i] = (float)from[i];
        finite &= isfinite(to[i]) != 0;
    }
    return finite;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int unit(double v[3]) {
    double length = sqrt(dot(v, v));
    if (!(length > 1e-300) || !isfinite(length))
        return 0;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return 1;
}

void scene_rigid(const double from[16], float to[16]) {
    double z[3], y[3], x[3];
    memcpy(z, from + 8, sizeof z);
    memcpy(y, from + 4, sizeof y);
    if (!unit(z))
        memcpy(z, (const double[3]){0.0, 0.0, 1.0}, sizeof z);
    for (int attempt = 0; attempt < 3; attempt++) {
        double along = dot(y, z);
        for (int i = 0; i < 3; i++)
            y[i] -= along * z[i];
        if (unit(y))
            break;
        memcpy(y,
               attempt == 0 ? (const double[3]){0.0, 1.0, 0.0} : (const double[3]){1.0, 0.0, 0.0},
               sizeof y);
    }
    x[0] = y[1] * z[2] - y[2] * z[1];
    x[1] = y[2] * z[0] - y[0] * z[2];
    x[2] = y[0] * z[1] - y[1] * z[0];
    for (int i = 0; i < 3; i++) {
        to[i] = (float)x[i];
        to[4 + i] = (float)y[i];
        to[8 + i] = (float)z[i];
        to[12 + i] = (float)from[12 + i];
        to[4 * i + 3] = 0.0f;
    }
    to[15] = 1.0f;
}

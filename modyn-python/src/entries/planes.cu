// The planes of a height field below the shapes that touch it, in the settings of a step: the CUDA form of
// `HeightGrid::plane_below`. The text before defines `real`, `SHAPES` and their `centers`, the numbers of the
// `SETTINGS`, of those before the first surface and of a `SURFACE`, and the `ROWS` and `COLUMNS` of the heights.
// A height that is not finite gives NaN.

#ifndef __CUDACC_RTC__
#include <math.h>
#endif

// A cell of the grid along one axis: the index of its first height, the place within it from 0 to 1, and 1 / its size, 0
// beyond the grid, where the ground is level.
struct Cell {
    int first;
    real part, slope;
};

static __device__ Cell cell_at(real at, real origin, real spacing, int count)
{
    const real place = (at - origin) / spacing;
    const real last = count - 2;
    const int first = !(place > 0) ? 0 : place > last ? count - 2 : (int)place;
    const real part = place - first;
    const bool inside = place >= 0 && place <= last + 1;
    return { first, part < 0 ? 0 : part > 1 ? 1 : part, inside ? 1 / spacing : 0 };
}

extern "C" __global__ void __launch_bounds__(128, 1) modyn_rows(
    const real *__restrict__ poses, const real *__restrict__ settings, const real *__restrict__ heights,
    const real *__restrict__ grid, real *__restrict__ out,
    unsigned int every0, unsigned int rows0, unsigned int stride0,
    unsigned int every1, unsigned int rows1, unsigned int stride1,
    unsigned int every2, unsigned int rows2, unsigned int stride2,
    unsigned int every3, unsigned int rows3, unsigned int stride3,
    unsigned int count)
{
    const size_t state = (size_t)blockIdx.x * blockDim.x + threadIdx.x;
    if (state >= count) { return; }
    poses += (size_t)((unsigned int)state / every0 % rows0) * stride0;
    settings += (size_t)((unsigned int)state / every1 % rows1) * stride1;
    heights += (size_t)((unsigned int)state / every2 % rows2) * stride2;
    grid += (size_t)((unsigned int)state / every3 % rows3) * stride3;
    out += state * SETTINGS;
    for (int k = 0; k < SETTINGS; ++k) { out[k] = settings[k]; }
    for (int shape = 0; shape < SHAPES; ++shape) {
        const real *pose = poses + 12 * shape;
        const real *center = centers + 3 * shape;
        real point[2];
        for (int k = 0; k < 2; ++k) {
            const real *row = pose + 3 * k;
            point[k] = row[0] * center[0] + row[1] * center[1] + row[2] * center[2] + pose[9 + k];
        }
        const Cell x = cell_at(point[0], grid[0], grid[2], COLUMNS);
        const Cell y = cell_at(point[1], grid[1], grid[3], ROWS);
        const real *corner = heights + (size_t)y.first * COLUMNS + x.first;
        const real left = corner[0] + (corner[COLUMNS] - corner[0]) * y.part;
        const real right = corner[1] + (corner[COLUMNS + 1] - corner[1]) * y.part;
        const real lower = corner[0] + (corner[1] - corner[0]) * x.part;
        const real upper = corner[COLUMNS] + (corner[COLUMNS + 1] - corner[COLUMNS]) * x.part;
        const real slope_x = (right - left) * x.slope;
        const real slope_y = (upper - lower) * y.slope;
        const real of_normal = 1 / sqrt(slope_x * slope_x + slope_y * slope_y + 1);
        const real normal[3] = { -slope_x * of_normal, -slope_y * of_normal, of_normal };
        const real of_first = 1 / sqrt(1 + slope_x * slope_x);
        const real first[3] = { of_first, 0, slope_x * of_first };
        real *plane = out + FIRST + SURFACE * shape;
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3, last = (k + 2) % 3;
            plane[3 * k] = first[k];
            plane[3 * k + 1] = normal[next] * first[last] - normal[last] * first[next];
            plane[3 * k + 2] = normal[k];
        }
        plane[9] = point[0];
        plane[10] = point[1];
        plane[11] = left + (right - left) * x.part;
    }
}

/* Pressure angle and curvature of many cams, as an engineer writes it in C: the largest of the samples of a turn.

   The formulas are those of Norton, Cam Design and Manufacturing Handbook, ch. 7. Lengths in mm, angles in rad.

   NUMBER is float or double. What samples miss is far more than what rounding to 24 bits changes, so that float is what
   an engineer who wants speed would take.

   designs  how many
   sizes    (designs, 6): base or mean radius, roller radius, offset, arm length, centre distance, face offset
   sense    +1 for a cam that turns counter-clockwise, -1 for clockwise
   lift     of the follower
   samples  how many
   motion   (5, samples): y, y', y'', and cos y and sin y for a follower that oscillates
   cells    of smooth motion between the joints of the law; of each the rate of t by the cam angle, t being -1 to 1
            from end to end, and the terms of y by powers of t: terms is (cells, TERMS + 1)
   each     samples of a cell at even t, both its ends included; samples after those of the last cell are of dwells
   found    (designs, 3): the largest |tan b|, the least and the largest curvature of the pitch curve in 1/mm; of a
            flat face, the least and the largest radius of curvature of the profile in mm */

#include <tgmath.h>

#define TERMS 12

#ifndef NUMBER
#define NUMBER float
#endif

typedef struct { NUMBER size, roller, offset, arm, centre, face, sense, lift; } design;
typedef struct { NUMBER size, arm, centre, face, sense, lead, height, cosine, sine; } cam;
typedef struct { NUMBER y, y1, y2, cosine, sine; } state;
typedef struct { NUMBER tangent, bend; } point;

#define INLINE static inline __attribute__((always_inline))

/* Curvature of a pitch curve that moves by (s, w) and turns by q with each radian of the cam. */
INLINE NUMBER curvature(NUMBER s, NUMBER w, NUMBER s1, NUMBER w1, NUMBER q) {
    NUMBER square = s * s + w * w;
    return (q * square - (w1 * s - w * s1)) / (square * sqrt(square));
}

INLINE cam disc_translating(design d) {
    NUMBER lead = d.sense * d.offset, prime = d.size + d.roller;
    return (cam){.lead = lead, .height = sqrt(fmax(prime * prime - lead * lead, 0))};
}

INLINE point at_disc_translating(cam c, state m) {
    NUMBER s = c.height + m.y, w = m.y1 - c.lead;
    return (point){w / s, curvature(s, w, m.y1, m.y2, 1)};
}

INLINE cam disc_translating_flat(design d) { return (cam){.size = d.size}; }

INLINE point at_disc_translating_flat(cam c, state m) { return (point){0, c.size + m.y + m.y2}; }

INLINE cam disc_oscillating(design d) {
    NUMBER prime = d.size + d.roller;
    NUMBER cosine = (d.centre * d.centre + d.arm * d.arm - prime * prime) / (2 * d.centre * d.arm);
    NUMBER sine = sqrt(fmax(1 - cosine * cosine, 0));
    return (cam){.arm = d.arm, .centre = d.centre, .sense = d.sense, .cosine = cosine, .sine = sine};
}

INLINE point at_disc_oscillating(cam c, state m) {
    NUMBER cosine = c.cosine * m.cosine - c.sine * m.sine, sine = c.sine * m.cosine + c.cosine * m.sine;
    NUMBER q = 1 + c.sense * m.y1, s = c.centre * sine, w = c.arm * q - c.centre * cosine;
    NUMBER s1 = c.centre * cosine * m.y1, w1 = c.sense * c.arm * m.y2 + s * m.y1;
    return (point){w / s, curvature(s, c.sense * w, s1, c.sense * w1, q)};
}

INLINE cam disc_oscillating_flat(design d) {
    NUMBER sine = (d.size - d.face) / d.centre, cosine = sqrt(fmax(1 - sine * sine, 0));
    return (cam){.face = d.face, .centre = d.centre, .sense = d.sense, .cosine = cosine, .sine = sine};
}

INLINE point at_disc_oscillating_flat(cam c, state m) {
    NUMBER cosine = c.cosine * m.cosine - c.sine * m.sine, sine = c.sine * m.cosine + c.cosine * m.sine;
    NUMBER q = 1 + c.sense * m.y1;
    NUMBER bend = (sine * (2 * q - 1) * q + cosine * m.y2) / (q * q * q);
    return (point){c.face * q / (c.centre * cosine), c.face + c.centre * bend};
}

INLINE cam cylindrical_translating(design d) { return (cam){.size = d.size}; }

INLINE point at_cylindrical_translating(cam c, state m) {
    return (point){m.y1 / c.size, curvature(c.size, -m.y1, 0, -m.y2, 0)};
}

INLINE cam cylindrical_oscillating(design d) {
    NUMBER start = -d.lift / 2;
    return (cam){.size = d.size, .arm = d.arm, .sense = d.sense, .cosine = cos(start), .sine = sin(start)};
}

INLINE point at_cylindrical_oscillating(cam c, state m) {
    NUMBER cosine = c.cosine * m.cosine - c.sine * m.sine, sine = c.sine * m.cosine + c.cosine * m.sine;
    NUMBER s = c.size * cosine, w = c.arm * m.y1 + c.sense * c.size * sine;
    NUMBER s1 = -c.size * sine * m.y1, w1 = c.arm * m.y2 + c.sense * s * m.y1;
    return (point){w / s, curvature(s, -w, s1, -w1, -c.sense * m.y1)};
}

enum { STEEPEST, LEAST, LARGEST };

/* The motion in a cell. */
INLINE state motion_in(const NUMBER *cell, NUMBER t) {
    NUMBER y = cell[TERMS], y1 = 0, half_y2 = 0;
    for (int k = TERMS - 1; k > 0; k--) half_y2 = half_y2 * t + y1, y1 = y1 * t + y, y = y * t + cell[k];
    return (state){y, y1 * cell[0], 2 * half_y2 * cell[0] * cell[0], cos(y), sin(y)};
}

/* What is largest at the extreme. */
INLINE NUMBER height(point p, int which) {
    return which == STEEPEST ? fabs(p.tangent) : which == LEAST ? -p.bend : p.bend;
}

/* The first sample of this value. */
INLINE long place(const NUMBER *samples, NUMBER value) {
    long j = 0;
    while (samples[j] != value) j++;
    return j;
}

/* The numbers of the curves that designs share, for each design. */
void share_out(long designs, const NUMBER *restrict curves, const int *restrict curve_of, NUMBER *restrict found) {
    for (long i = 0; i < designs; i++)
        for (int k = 0; k < 3; k++) found[3 * i + k] = curves[3 * curve_of[i] + k];
}

#define WORKS(NAME)                                                                                               \
    /* The extremes of the samples; the samples too, where there is room for them. */                             \
    INLINE void sample_##NAME(cam c, long samples, const NUMBER *restrict motion, NUMBER *restrict found,         \
                              NUMBER *restrict tangents, NUMBER *restrict bends) {                                \
        const NUMBER *y = motion, *y1 = y + samples, *y2 = y1 + samples, *cosine = y2 + samples,                  \
                     *sine = cosine + samples;                                                                    \
        NUMBER steepest = 0, least = 1e30, largest = -1e30;                                                       \
        for (long j = 0; j < samples; j++) {                                                                      \
            point p = at_##NAME(c, (state){y[j], y1[j], y2[j], cosine[j], sine[j]});                              \
            NUMBER tangent = fabs(p.tangent);                                                                     \
            if (tangents) tangents[j] = tangent, bends[j] = p.bend;                                               \
            steepest = tangent > steepest ? tangent : steepest;                                                   \
            least = p.bend < least ? p.bend : least;                                                              \
            largest = p.bend > largest ? p.bend : largest;                                                        \
        }                                                                                                         \
        found[STEEPEST] = steepest, found[LEAST] = least, found[LARGEST] = largest;                               \
    }                                                                                                             \
                                                                                                                  \
    void NAME##_extremes(long designs, const NUMBER *restrict sizes, NUMBER sense, NUMBER lift, long samples,     \
                         const NUMBER *restrict motion, NUMBER *restrict found) {                                 \
        for (long i = 0; i < designs; i++) {                                                                      \
            const NUMBER *d = sizes + 6 * i;                                                                      \
            cam c = NAME((design){d[0], d[1], d[2], d[3], d[4], d[5], sense, lift});                              \
            sample_##NAME(c, samples, motion, found + 3 * i, 0, 0);                                               \
        }                                                                                                         \
    }                                                                                                             \
                                                                                                                  \
    /* An extreme of the continuous motion near its best sample: the vertex of a parabola, then of a narrow one. */\
    INLINE NUMBER polish_##NAME(cam c, const NUMBER *terms, long each, long j, NUMBER best, int which) {          \
        const NUMBER *cell = terms + (TERMS + 1) * (j / each);                                                    \
        NUMBER apart = 2 / (NUMBER)(each - 1), t = apart * (j % each) - 1, steps[] = {apart / 4, apart / 64}, f[3];\
        for (int k = 0; k < 2; k++) {                                                                             \
            NUMBER h = steps[k];                                                                                  \
            t = fmin(fmax(t, h - 1), 1 - h);                                                                      \
            for (int i = 0; i < 3; i++) f[i] = height(at_##NAME(c, motion_in(cell, t + h * (i - 1))), which);     \
            NUMBER bend = f[0] - 2 * f[1] + f[2], move = bend < 0 ? (f[0] - f[2]) / (2 * bend) : f[2] - f[0];     \
            best = fmax(best, fmax(f[1], fmax(f[0], f[2])));                                                      \
            t += h * fmin(fmax(move, -4), 4);                                                                     \
        }                                                                                                         \
        return fmax(best, height(at_##NAME(c, motion_in(cell, fmin(fmax(t, -1), 1))), which));                    \
    }                                                                                                             \
                                                                                                                  \
    void NAME##_polished(long designs, const NUMBER *restrict sizes, NUMBER sense, NUMBER lift, long samples,     \
                         const NUMBER *restrict motion, NUMBER *restrict found, long cells,                       \
                         const NUMBER *restrict terms, long each) {                                               \
        NUMBER tangents[samples], bends[samples];                                                                 \
        for (long i = 0; i < designs; i++, found += 3) {                                                          \
            const NUMBER *d = sizes + 6 * i;                                                                      \
            cam c = NAME((design){d[0], d[1], d[2], d[3], d[4], d[5], sense, lift});                              \
            sample_##NAME(c, samples, motion, found, tangents, bends);                                            \
            for (int which = 0; which < 3; which++) {                                                             \
                long j = place(which == STEEPEST ? tangents : bends, found[which]);                               \
                NUMBER sign = which == LEAST ? -1 : 1;                                                            \
                long first = j % each == 0 && j > 0 ? j - 1 : j, last = j % each == each - 1 ? j + 1 : j;         \
                for (j = first; j <= last && j < cells * each; j++)  /* in both cells at a joint */               \
                    found[which] = sign * polish_##NAME(c, terms, each, j, sign * found[which], which);           \
            }                                                                                                     \
        }                                                                                                         \
    }

WORKS(disc_translating)
WORKS(disc_translating_flat)
WORKS(disc_oscillating)
WORKS(disc_oscillating_flat)
WORKS(cylindrical_translating)
WORKS(cylindrical_oscillating)

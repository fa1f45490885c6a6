#include <stdint.h>
#include <string.h>

/* Sine and cosine within 0.8 units in the last place, the same to the last bit on every machine of
 * IEEE 754 as long as products and sums are not fused (-ffp-contract=off, or -std=c99). The angle is
 * reduced with pi/2 in three parts (Cody and Waite, 1980); the polynomials are those of fdlibm. */
static void bksim_turn(double x, double *sine, double *cosine) {
    const double rounded = x * 0.6366197723675814 + 6755399441055744.0;
    const double k = rounded - 6755399441055744.0;
    const double first = x - k * 1.5707963267341256;
    const double middle = k * 6.077100506303966e-11;
    const double second = first - middle;
    const double part = k * 2.0222662487959506e-21 - ((first - second) - middle);
    const double y = second - part;
    const double e = part - (second - y);
    const double near = first - k * 6.077100506506192e-11;
    const double y2 = near * near;
    const double y4 = near * near * (near * near);
    const double y3 = y2 * near;
    const double y8 = y4 * y4;
    const double half = 0.5 * y2;
    const double lead = 1.0 - half;
    const double s = ((-0.16666666666666632 + y2 * 0.00833333333332249)
                      + y4 * (-0.0001984126982985795 + y2 * 2.7557313707070068e-06))
                     + y8 * (-2.5050760253406863e-08 + y2 * 1.58969099521155e-10);
    const double c = ((0.0416666666666666 + y2 * -0.001388888888887411)
                      + y4 * (2.480158728947673e-05 + y2 * -2.7557314351390663e-07))
                     + y8 * (2.087572321298175e-09 + y2 * -1.1359647557788195e-11);
    const double a = y - (e * lead - y3 * s);
    const double b = lead + (((1.0 - lead) - half) + (y4 * c + y * e));
    uint64_t quadrant, a_bits, b_bits, swapped;
    memcpy(&quadrant, &rounded, sizeof quadrant);
    memcpy(&a_bits, &a, sizeof a_bits);
    memcpy(&b_bits, &b, sizeof b_bits);
    swapped = (a_bits ^ b_bits) & (0 - (quadrant & 1));
    a_bits ^= swapped ^ ((quadrant & 2) << 62);
    b_bits ^= swapped ^ (((quadrant + 1) & 2) << 62);
    memcpy(sine, &a_bits, sizeof a_bits);
    memcpy(cosine, &b_bits, sizeof b_bits);
}


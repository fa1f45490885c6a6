/* Sines and cosines of some angles: called one by one, or, with VECTOR_SINE, in loops for which
 * the compiler takes the vector functions of its mathematical library. */
#include <math.h>

#ifdef VECTOR_SINE
#define TURN(n, angle, s, c)                            \
    for (int i_ = 0; i_ < (n); i_++) s[i_] = sin(angle[i_]); \
    for (int i_ = 0; i_ < (n); i_++) c[i_] = cos(angle[i_])
#else
#define TURN(n, angle, s, c)          \
    for (int i_ = 0; i_ < (n); i_++) { \
        s[i_] = sin(angle[i_]);       \
        c[i_] = cos(angle[i_]);       \
    }
#endif

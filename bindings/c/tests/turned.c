/* A joint angle that is a whole turn off is the same angle: inclinometers count within a turn. */
#undef NDEBUG
#include <assert.h>
#include <math.h>

#include "heft.h"

static const double TURN = 6.283185307179586;
static uint64_t memory[2][HEFT_SIZE_MAX / 8];

int main(void)
{
    const uint32_t columns = HEFT_EXCAVATOR_COLUMN_SWING_VELOCITY | HEFT_EXCAVATOR_COLUMN_SWING_TORQUE |
                             HEFT_EXCAVATOR_COLUMN_BOOM_ANGLE | HEFT_EXCAVATOR_COLUMN_ARM_ANGLE |
                             HEFT_EXCAVATOR_COLUMN_BUCKET_ANGLE;
    heft_excavator_sample sample;
    heft_excavator_estimate estimate[2];
    int i, k;

    for (k = 0; k < 2; k++)
        assert(heft_excavator_init(memory[k], sizeof memory[k], NULL, HEFT_EXCAVATOR_METHOD_AUTO, columns) == HEFT_OK);
    for (i = 0; i < 2000; i++) {
        assert(heft_excavator_clear(&sample) == HEFT_OK);
        sample.t = 0.01 * i;
        sample.swing_velocity = 0.5 * sin(0.01 * i);
        sample.swing_torque = 6000.0 * cos(0.01 * i) + 1500.0 * sample.swing_velocity;
        sample.boom_angle = 0.6;
        sample.arm_angle = -1.6;
        sample.bucket_angle = -1.0 + 0.2 * sin(0.003 * i);
        assert(heft_excavator_step(memory[0], &sample, &estimate[0]) == HEFT_OK);
        sample.bucket_angle += i % 200 < 100 ? TURN : 0.0;
        assert(heft_excavator_step(memory[1], &sample, &estimate[1]) == HEFT_OK);
        assert(estimate[0].flags == estimate[1].flags && estimate[0].reason == estimate[1].reason);
        assert(fabs(estimate[0].inertia - estimate[1].inertia) < 1e-6 * estimate[0].inertia);
    }
    return 0;
}

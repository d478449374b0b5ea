/* The main loop of a robot with an exported controller. */

#include FILE
#include "board.h"

#define JOINED(name, part) name##_##part
#define OF(name, part) JOINED(name, part)

int main(void)
{
    static const float still_outputs[2] = {0.5f, 0.5f}, still[2] = {0.0f, 0.0f};
    OF(NAME, state) state;
    float inputs[OF(NAME, INPUTS) + 1], outputs[2], speeds[2];

    board_begin();
    board_checked(OF(NAME, check)());
    OF(NAME, reset)(&state SEEDS);
    for (;;) {
        if (board_read(inputs, OF(NAME, INPUTS))) {
            OF(NAME, step)(&state, inputs, outputs);
            OF(NAME, wheels)(outputs, speeds);
            board_drive(outputs, speeds);
        } else {
            board_drive(still_outputs, still);
        }
    }
}

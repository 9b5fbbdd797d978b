"""Files of MuJoCo, written by hand in the styles of public ones: what each becomes, or why it is refused."""

HEAD = '<mujoco model="{0}"><compiler angle="radian"/><option gravity="0 0 -9.81"/><worldbody>'
CRANK = '<body name="crank"><joint name="O" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.1 0 0.05" size="0.01"/>'

#: Machines that move as in MuJoCo: text, mass of the moving links [kg], degrees of freedom.
OPEN = {
    "pendulum": (HEAD + CRANK + "</body></worldbody></mujoco>", None, 1),
    "degrees are the usual angles": (
        '<mujoco><worldbody><body name="arm" euler="0 30 0"><joint name="O" type="hinge" axis="0 1 0" range="-90 90"/>'
        '<inertial pos="0.2 0 0" mass="0.5" diaginertia="0.001 0.002 0.002"/></body></worldbody></mujoco>',
        0.5,
        1,
    ),
    "cart and pole": (
        '<mujoco model="cartpole"><compiler inertiafromgeom="true"/><default><joint armature="0" damping="0.1"/>'
        '<geom density="800" rgba=".4 .4 .4 1"/><motor ctrlrange="-3 3"/></default><worldbody>'
        '<light pos="0 0 3"/><geom name="rail" type="capsule" size="0.02 1" pos="0 0 0" quat="0.707 0 0.707 0"/>'
        '<body name="cart" pos="0 0 0.1"><joint name="slider" type="slide" axis="1 0 0" limited="true" range="-1 1"/>'
        '<geom name="cart" type="box" size="0.1 0.05 0.03"/><body name="pole" pos="0 0 0.02">'
        '<joint name="hinge" type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.1 0 0.6" size="0.02 0.3"/>'
        '</body></body></worldbody><actuator><motor name="push" joint="slider" gear="100"/></actuator></mujoco>',
        None,
        2,
    ),
    "acrobot": (
        '<mujoco model="acrobot"><default><joint damping=".05"/><geom type="capsule" size="0.05" mass="1"/></default>'
        '<worldbody><body name="upper_arm" pos="0 0 2"><joint name="shoulder" type="hinge" axis="0 1 0"/>'
        '<geom name="upper_arm" fromto="0 0 0 0.3 0 1"/><body name="lower_arm" pos="0.3 0 1">'
        '<joint name="elbow" type="hinge" axis="0 1 0"/><geom name="lower_arm" fromto="0 0 0 -0.4 0 0.8"/>'
        '<site name="tip" pos="-0.4 0 0.8" size="0.01"/></body></body></worldbody>'
        '<actuator><motor name="elbow" joint="elbow" gear="2"/></actuator></mujoco>',
        2.0,
        2,
    ),
    "springs and a reference angle": (
        '<mujoco><compiler angle="radian"/><option gravity="0 -9.81 0"/><worldbody><body name="arm">'
        '<joint name="O" axis="0 0 1" ref="0.2" stiffness="3" springref="0.5" damping="0.02"/>'
        '<inertial pos="0.2 0 0" mass="0.5" diaginertia="0.001 0.002 0.002"/><body name="bob" pos="0.4 0 0">'
        '<joint name="S" type="slide" axis="1 0 0" stiffness="300" springref="0.02" damping="0.5"/>'
        '<inertial pos="0 0 0" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/></body></body></worldbody></mujoco>',
        0.7,
        2,
    ),
    "a rotor's inertia at the ground": (
        HEAD + CRANK.replace('name="O"', 'name="O" armature="0.003"') + "</body></worldbody></mujoco>",
        None,
        1,
    ),
    "servos": (
        HEAD
        + CRANK
        + '<body name="arm" pos="0.1 0 0.05"><joint name="A" axis="0 1 0" ref="0.3"/><geom type="box" size="0.05 0.01 0.01"'
        ' pos="0.05 0 0" mass="0.3"/></body></body></worldbody><actuator><position joint="O" kp="4" kv="0.02"/>'
        '<velocity joint="A" kv="0.01" gear="2"/><general joint="A" biastype="affine" biasprm="0 -0.5 -0.01"/>'
        "</actuator></mujoco>",
        None,
        2,
    ),
    "classes and child classes": (
        '<mujoco><compiler angle="radian"/><default><geom type="capsule" size="0.02"/><default class="heavy">'
        '<geom density="7800"/><joint damping="0.3"/><default class="heavier"><geom density="11000"/></default></default>'
        '<default class="light"><geom mass="0.1"/></default></default><worldbody><body name="a" childclass="heavy">'
        '<joint name="A" axis="0 1 0"/><geom fromto="0 0 0 0.2 0 0"/><body name="b" pos="0.2 0 0">'
        '<joint name="B" axis="0 1 0"/><geom fromto="0 0 0 0.1 0 0.1" class="light"/><geom fromto="0.1 0 0.1 0.2 0 0"'
        ' class="heavier"/></body></body></worldbody></mujoco>',
        None,
        2,
    ),
    "frames, axes and angles": (
        '<mujoco><compiler angle="degree" eulerseq="zyx"/><option gravity="0 -9.81 0"/><worldbody>'
        '<frame pos="0.1 0 0" euler="20 0 0"><body name="a" xyaxes="0 1 0 -1 0 0"><joint name="A" axis="0 0 1"/>'
        '<geom type="cylinder" size="0.03 0.1" pos="0.1 0 0" zaxis="1 0 0"/><frame axisangle="0 0 1 35"><body name="b"'
        ' pos="0.2 0 0"><joint name="B" axis="0 0 -1" pos="0.02 0 0"/><geom type="ellipsoid" size="0.1 0.02 0.03"/>'
        "</body></frame></body></frame></worldbody></mujoco>",
        None,
        2,
    ),
    "three joints in a body": (
        '<mujoco><option gravity="0 0 -9.81"/><worldbody><body name="torso" pos="0 0 1">'
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1" damping="2"/>'
        '<joint name="turn" type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.2 0 0.4" size="0.05"/>'
        '<body name="thigh" pos="0 0 0"><joint name="hip" type="hinge" axis="0 1 0" stiffness="20" damping="0.1"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04"/></body></body></worldbody></mujoco>',
        None,
        4,
    ),
    "a body without joints, and a weightless one": (
        '<mujoco><compiler angle="radian"/><worldbody><body name="base" pos="0 0 1"><geom type="box" size="1 1 0.1"/>'
        '<body name="a"><joint name="A" axis="0 1 0"/><geom type="sphere" size="0.05" pos="0.2 0 0"/>'
        '<body name="tool" pos="0.3 0 0"><geom type="box" size="0.02 0.02 0.02"/></body>'
        '<body name="b" pos="0.3 0 0" gravcomp="1"><joint name="B" axis="0 1 0"/>'
        '<geom type="sphere" size="0.03" pos="0.1 0 0.1"/></body></body></body></worldbody></mujoco>',
        None,
        2,
    ),
}

#: Machines with loops or couplings: the same, with MuJoCo's constraints as stiff as they go.
STIFF = 'solref="-4e8 -4e4" solimp="0.9999 0.9999 0.001"'
SLIDER_CRANK = (
    '<body name="slider" pos="0.4 0 0"><joint name="S" type="slide" axis="1 0 0"/><geom type="box" mass="0.5"'
    ' size="0.03 0.03 0.03"/></body></worldbody><equality>'
)
CLOSED = {
    "slider-crank by connect": (
        HEAD
        + CRANK
        + '<body name="rod" pos="0.1 0 0.05"><joint name="A" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0 -0.05"'
        ' size="0.008"/></body></body>'
        + SLIDER_CRANK
        + f'<connect body1="rod" body2="slider" anchor="0.3 0 -0.05" {STIFF}/></equality></mujoco>',
        None,
        1,
    ),
    "four-bar by sites": (
        HEAD
        + CRANK
        + '<body name="coupler" pos="0.1 0 0.05"><joint name="A" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.25 0 0.1"'
        ' size="0.008"/><site name="end" pos="0.25 0 0.1"/></body></body><body name="rocker" pos="0.35 0 -0.05">'
        '<joint name="C" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.01"/>'
        '<site name="top" pos="0 0 0.2"/></body></worldbody>'
        f'<equality><connect name="B" site1="end" site2="top" {STIFF}/></equality></mujoco>',
        None,
        1,
    ),
    "a gripper with coupled fingers": (
        HEAD
        + '<body name="left"><joint name="L" type="slide" axis="1 0 0" stiffness="100"/><geom type="box" mass="0.2"'
        ' size="0.01 0.01 0.04"/></body><body name="right" pos="0.1 0 0"><joint name="R" type="hinge" axis="0 1 0"/>'
        '<geom type="box" mass="0.3" size="0.01 0.01 0.04" pos="0 0 -0.04"/></body></worldbody>'
        f'<equality><joint joint1="L" joint2="R" polycoef="0 0.05 0 0 0" {STIFF}/></equality></mujoco>',
        0.5,
        1,
    ),
    "welded bodies": (
        HEAD
        + CRANK
        + '</body><body name="fork" pos="0.05 0 0"><joint name="F" axis="0 1 0" pos="-0.05 0 0"/><geom type="sphere" size="0.02"/>'
        f'</body></worldbody><equality><weld body1="crank" body2="fork" {STIFF}/></equality></mujoco>',
        None,
        1,
    ),
}

#: Files that are refused, and the reason.
REFUSED = {
    "a body of a mesh": (
        '<mujoco><asset><mesh name="m" file="m.stl"/></asset><worldbody><body name="a"><joint name="A"/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>',
        "is a mesh, whose inertia is not computed; write <inertial>, or mass 0",
    ),
    "a curve of joints": (
        '<mujoco><worldbody><body name="a"><joint name="A"/><geom size="0.1"/></body><body name="b"><joint name="B"/>'
        '<geom size="0.1"/></body></worldbody><equality><joint joint1="A" joint2="B" polycoef="0 1 0.5"/></equality></mujoco>',
        "couples joints by a curve; polycoef must be two numbers and zeros",
    ),
    "a swimmer": (
        '<mujoco><option density="4000" viscosity="0.1"/><worldbody><body name="a"><joint name="A"/><geom size="0.1"/>'
        "</body></worldbody></mujoco>",
        "is a medium that acts on links; remove it",
    ),
    "a body moved from outside": (
        '<mujoco><worldbody><body name="a" mocap="true"><geom size="0.1"/></body></worldbody></mujoco>',
        "is moved from outside (mocap); fix it, or give it a joint",
    ),
    "many bodies from one": (
        '<mujoco><worldbody><replicate count="3"><body name="a"/></replicate></worldbody></mujoco>',
        "<worldbody>/<replicate>: is not supported; remove it",
    ),
    "joints in space": (
        '<mujoco><worldbody><body name="a"><joint name="A" axis="0 1 0"/><geom size="0.1"/><body name="b" pos="1 0 0">'
        '<joint name="B" axis="1 0 0"/><geom size="0.1"/></body></body></worldbody></mujoco>',
        'not planar: its axis is not parallel to the axis of "A" by 1.57 rad (90 degrees)',
    ),
}

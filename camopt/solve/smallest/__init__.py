"""The smallest cam: closed forms, cutting planes, branch and bound over sizes and angles, prices of bounds."""

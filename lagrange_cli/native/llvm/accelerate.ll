; Rates of the velocities and integrals at one state (its low parts are zeros); 0 where the mass
; matrix is singular. program.py fills in the @@names@@.
define i64 @accelerate(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %out) #0 {
entry:
  %regular = call i1 @jet(ptr %constants, double %t, ptr %state, ptr %work)
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
  %place = add i64 %i, @@slot@@
  %aa = getelementptr inbounds double, ptr %work, i64 %place
  %a = load double, ptr %aa, align 8
  %oa = getelementptr inbounds double, ptr %out, i64 %i
  store double %a, ptr %oa, align 8
  %next = add nuw nsw i64 %i, 1
  %more = icmp ult i64 %next, @@rates@@
  br i1 %more, label %loop, label %done
done:
  %code = zext i1 %regular to i64
  ret i64 %code
}

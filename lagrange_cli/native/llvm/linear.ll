; Factorization and solution of one large diagonal block of the mass matrix, in place: any matrix, by P M = L U with
; partial pivoting (definite.ll has the others). %swaps becomes the row that each row was exchanged with. Rows are %stride
; doubles long.

define internal i1 @factor_general(ptr noalias %a, ptr noalias %swaps, i64 %n, i64 %stride, double %floor) #0 {
entry:
  br label %measure
measure:
  %g = phi i64 [ 0, %entry ], [ %gn, %measured ]
  %swapg = getelementptr inbounds double, ptr %swaps, i64 %g
  br label %size
size:
  %h = phi i64 [ 0, %measure ], [ %hn, %size ]
  %top = phi double [ 0.0, %measure ], [ %top1, %size ]
  %hrow = mul i64 %h, %stride
  %hat = add i64 %hrow, %g
  %hp = getelementptr inbounds double, ptr %a, i64 %hat
  %hv = load double, ptr %hp, align 8
  %ha = call double @llvm.fabs.f64(double %hv)
  %top1 = call double @llvm.maxnum.f64(double %top, double %ha)
  %hn = add i64 %h, 1
  %hmore = icmp ult i64 %hn, %n
  br i1 %hmore, label %size, label %measured
measured:
  store double %top1, ptr %swapg, align 8
  %gn = add i64 %g, 1
  %gmore = icmp ult i64 %gn, %n
  br i1 %gmore, label %measure, label %pivot
pivot:
  %j = phi i64 [ 0, %measured ], [ %jn, %rows_done ]
  %regular = phi i1 [ true, %measured ], [ %regular1, %rows_done ]
  br label %search
search:
  %s = phi i64 [ %j, %pivot ], [ %sn, %search ]
  %best = phi i64 [ %j, %pivot ], [ %best1, %search ]
  %largest = phi double [ -1.0, %pivot ], [ %largest1, %search ]
  %srow = mul i64 %s, %stride
  %sat = add i64 %srow, %j
  %sp = getelementptr inbounds double, ptr %a, i64 %sat
  %sv = load double, ptr %sp, align 8
  %sa = call double @llvm.fabs.f64(double %sv)
  %more = fcmp ogt double %sa, %largest
  %best1 = select i1 %more, i64 %s, i64 %best
  %largest1 = select i1 %more, double %sa, double %largest
  %sn = add i64 %s, 1
  %smore = icmp ult i64 %sn, %n
  br i1 %smore, label %search, label %found
found:
  %swapp = getelementptr inbounds double, ptr %swaps, i64 %j
  %scale = load double, ptr %swapp, align 8
  %least = fmul double %scale, %floor
  %good = fcmp ogt double %largest1, %least
  %regular1 = and i1 %regular, %good
  %coded = bitcast i64 %best1 to double
  store double %coded, ptr %swapp, align 8
  %jrow = mul i64 %j, %stride
  %jp = getelementptr inbounds double, ptr %a, i64 %jrow
  %brow = mul i64 %best1, %stride
  %bp = getelementptr inbounds double, ptr %a, i64 %brow
  br label %swap
swap:
  %c = phi i64 [ 0, %found ], [ %cn, %swap ]
  %cjp = getelementptr inbounds double, ptr %jp, i64 %c
  %cbp = getelementptr inbounds double, ptr %bp, i64 %c
  %cj = load double, ptr %cjp, align 8
  %cb = load double, ptr %cbp, align 8
  store double %cb, ptr %cjp, align 8
  store double %cj, ptr %cbp, align 8
  %cn = add i64 %c, 1
  %cmore = icmp ult i64 %cn, %n
  br i1 %cmore, label %swap, label %swapped
swapped:
  %djp = getelementptr inbounds double, ptr %jp, i64 %j
  %d = load double, ptr %djp, align 8
  %first = add i64 %j, 1
  %any = icmp ult i64 %first, %n
  br i1 %any, label %row, label %rows_done
row:
  %i = phi i64 [ %first, %swapped ], [ %in, %row_done ]
  %irow = mul i64 %i, %stride
  %ip = getelementptr inbounds double, ptr %a, i64 %irow
  %fp = getelementptr inbounds double, ptr %ip, i64 %j
  %above = load double, ptr %fp, align 8
  %f = fdiv double %above, %d
  store double %f, ptr %fp, align 8
  %nf = fneg double %f
  br label %column
column:
  %k = phi i64 [ %first, %row ], [ %kn, %column ]
  %xp = getelementptr inbounds double, ptr %jp, i64 %k
  %x = load double, ptr %xp, align 8
  %yp = getelementptr inbounds double, ptr %ip, i64 %k
  %y = load double, ptr %yp, align 8
  %z = call double @llvm.fmuladd.f64(double %nf, double %x, double %y)
  store double %z, ptr %yp, align 8
  %kn = add i64 %k, 1
  %kmore = icmp ult i64 %kn, %n
  br i1 %kmore, label %column, label %row_done
row_done:
  %in = add i64 %i, 1
  %imore = icmp ult i64 %in, %n
  br i1 %imore, label %row, label %rows_done
rows_done:
  %jn = add i64 %j, 1
  %jmore = icmp ult i64 %jn, %n
  br i1 %jmore, label %pivot, label %done
done:
  ret i1 %regular1
}

define internal void @solve_general(ptr noalias %a, ptr noalias %swaps, ptr noalias %b, i64 %n, i64 %stride) #0 {
entry:
  br label %exchange
exchange:
  %e = phi i64 [ 0, %entry ], [ %en, %exchange ]
  %sp = getelementptr inbounds double, ptr %swaps, i64 %e
  %sd = load double, ptr %sp, align 8
  %s = bitcast double %sd to i64
  %ep = getelementptr inbounds double, ptr %b, i64 %e
  %op = getelementptr inbounds double, ptr %b, i64 %s
  %ev = load double, ptr %ep, align 8
  %ov = load double, ptr %op, align 8
  store double %ov, ptr %ep, align 8
  store double %ev, ptr %op, align 8
  %en = add i64 %e, 1
  %emore = icmp ult i64 %en, %n
  br i1 %emore, label %exchange, label %forward
forward:
  %j = phi i64 [ 0, %exchange ], [ %jn, %forward_done ]
  %jrow = mul i64 %j, %stride
  %jp = getelementptr inbounds double, ptr %a, i64 %jrow
  %bjp = getelementptr inbounds double, ptr %b, i64 %j
  %bj = load double, ptr %bjp, align 8
  %anyl = icmp ugt i64 %j, 0
  br i1 %anyl, label %lower, label %forward_done
lower:
  %k = phi i64 [ 0, %forward ], [ %kn, %lower ]
  %acc = phi double [ %bj, %forward ], [ %acc1, %lower ]
  %lp = getelementptr inbounds double, ptr %jp, i64 %k
  %l = load double, ptr %lp, align 8
  %nl = fneg double %l
  %xp = getelementptr inbounds double, ptr %b, i64 %k
  %x = load double, ptr %xp, align 8
  %acc1 = call double @llvm.fmuladd.f64(double %nl, double %x, double %acc)
  %kn = add i64 %k, 1
  %kmore = icmp ult i64 %kn, %j
  br i1 %kmore, label %lower, label %forward_done
forward_done:
  %y = phi double [ %bj, %forward ], [ %acc1, %lower ]
  store double %y, ptr %bjp, align 8
  %jn = add i64 %j, 1
  %jmore = icmp ult i64 %jn, %n
  br i1 %jmore, label %forward, label %backward
backward:
  %m1 = phi i64 [ %n, %forward_done ], [ %m, %backward_done ]
  %m = sub i64 %m1, 1
  %mrow = mul i64 %m, %stride
  %mp = getelementptr inbounds double, ptr %a, i64 %mrow
  %bmp = getelementptr inbounds double, ptr %b, i64 %m
  %bm = load double, ptr %bmp, align 8
  %anyu = icmp ult i64 %m1, %n
  br i1 %anyu, label %upper, label %backward_done
upper:
  %q = phi i64 [ %m1, %backward ], [ %qn, %upper ]
  %uacc = phi double [ %bm, %backward ], [ %uacc1, %upper ]
  %up = getelementptr inbounds double, ptr %mp, i64 %q
  %u = load double, ptr %up, align 8
  %nu = fneg double %u
  %vp = getelementptr inbounds double, ptr %b, i64 %q
  %v = load double, ptr %vp, align 8
  %uacc1 = call double @llvm.fmuladd.f64(double %nu, double %v, double %uacc)
  %qn = add i64 %q, 1
  %qmore = icmp ult i64 %qn, %n
  br i1 %qmore, label %upper, label %backward_done
backward_done:
  %w = phi double [ %bm, %backward ], [ %uacc1, %upper ]
  %dp = getelementptr inbounds double, ptr %mp, i64 %m
  %d = load double, ptr %dp, align 8
  %solved = fdiv double %w, %d
  store double %solved, ptr %bmp, align 8
  %again = icmp ugt i64 %m, 0
  br i1 %again, label %backward, label %done
done:
  ret void
}
